#pragma once
/// The one scan at a time that browsers upload: from the body of a request into a socket whose other end the printer has. Nothing of it is
/// kept here, and nothing is looked at.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/page/http_server.hpp"

namespace plumbline::firmware::inline page {

class PageUpload {
 public:
  enum class Stage : std::uint8_t {
    kFree,
    kAsked,    ///< the printer has not answered yet
    kReady,    ///< the printer takes it: the body may come
    kComing,   ///< a request's body comes
    kWaiting,  ///< all of it is sent: the printer has not said yet that it is kept
  };

  /// Begins.
  /// @pre stage() is kFree
  /// @returns the printer's end; not open: errno has the reason, and nothing has begun
  [[nodiscard]] Descriptor offer(std::uint64_t bytes);
  /// The printer takes it. @param number  of the state's `upload`
  void accepted(std::uint32_t number);
  /// Ends it, whoever still waits. The printer sees that not all came.
  void drop();

  /// A request whose body is the scan.
  /// @returns whether its body may come
  bool begin(std::uint32_t number, std::uint64_t bytes, const HttpTicket& ticket);
  /// Sends what has come of the body to the printer.
  /// @returns bytes sent; fewer than there are: wants_room(); none: the printer takes no more
  [[nodiscard]] std::optional<std::size_t> take(std::span<const char> bytes);
  /// All of the body has come. @pre stage() is kComing
  void whole();
  bool is_of(const HttpTicket& ticket) const;

  /// Takes note of a state line. From then on outcome() is what became of the upload, if that is known.
  void look_at(std::string_view state);
  /// The printer's answer for the browser, as JSON, without its end; empty: it is not known yet.
  std::string_view outcome() const { return outcome_.view(); }
  bool is_kept() const { return is_kept_; }

  Stage stage() const { return stage_; }
  const HttpTicket& ticket() const { return ticket_; }
  /// Becomes writable when there is room again. @pre wants_room()
  int descriptor() const { return into_.get(); }
  bool wants_room() const { return wants_room_; }
  /// There is room again, or the printer takes no more.
  void has_room() { wants_room_ = false; }

 private:
  Stage stage_ = Stage::kFree;
  Descriptor into_;
  std::uint32_t number_ = 0;
  std::uint64_t bytes_ = 0;
  HttpTicket ticket_;
  bool wants_room_ = false;
  bool is_kept_ = false;
  FixedText<512> outcome_;
};

}  // namespace plumbline::firmware::inline page
