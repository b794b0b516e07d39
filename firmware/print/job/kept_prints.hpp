#pragma once
/// Keeps the reports and previews of the last prints on the printer:
///
///   STATE/prints/00000012   of print 12: facts, report (JSON), preview (PNG), and a hash of them
///   STATE/prints/new        one that is being written
///
/// A file gets its number when it is complete and durable, so a power cut costs at most the print that has just ended.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/text_sink.hpp"
#include "firmware/print/job/job_file.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/function_ref.hpp"

namespace plumbline::firmware {

/// What lists of prints show. Stored byte for byte.
struct KeptPrint {
  std::uint32_t number = 0;  ///< from 1 on; never used twice while one is kept
  std::uint32_t result = 0;  ///< PrintState at the end
  std::uint32_t layers = 0;
  std::uint32_t layers_done = 0;
  ShortName scan = {};
  ShortName profile = {};
  std::int64_t ended_at = 0;  ///< s since 1970, by this machine's clock; 0: it was not set
  double resin_ml = 0;
  std::uint64_t report_bytes = 0;
  std::uint64_t preview_bytes = 0;  ///< 0: there is none
};

class KeptPrints {
 public:
  static constexpr std::size_t kMost = 12;
  /// Of all prints together: a report has some 400 bytes a layer.
  static constexpr std::uint64_t kMostBytes = std::uint64_t{32} << 20U;
  /// Of one print; a longer report is not kept.
  static constexpr std::uint64_t kMostOfOne = std::uint64_t{8} << 20U;

  enum class Part : std::uint8_t { kReport, kPreview };

  /// Creates the folder if it is missing. Removes what is torn or too much; what can't be read now stays where it is, unlisted.
  /// @param state  folder of the JobStore, which has locked it
  /// @param tell   gets a sentence for each print that is torn or can't be read
  /// @retval ErrorCode::kCannotOpen  the path, the reason
  [[nodiscard]] static Expected<KeptPrints> open(const std::string& state, FunctionRef<void(std::string_view)> tell);

  /// Newest first.
  std::span<const KeptPrint> list() const { return std::span(list_).first(count_); }

  /// Keeps a print and drops the oldest ones where there are too many. Where the storage is full, it drops as many as make room, and
  /// none if all together have too few bytes. Durable when it returns. Takes nothing from the heap.
  /// @param facts    number and sizes are set here
  /// @param write    writes the report; called again where room had to be made
  /// @param preview  PNG; empty: there is none
  /// @retval ErrorCode::kCannotWrite  this print is not kept
  [[nodiscard]] Status keep(KeptPrint facts, FunctionRef<Status(TextSink&)> write, std::span<const std::byte> preview);

  struct Got {
    std::size_t bytes = 0;   ///< of this part
    std::uint64_t size = 0;  ///< of all of it
  };
  /// Reads from a kept print.
  /// @param from  the first byte
  /// @param out   filled from its start
  /// @retval ErrorCode::kBadSetting  no such print is kept, or it has no preview
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] Expected<Got> read(std::uint32_t number, Part part, std::uint64_t from, std::span<std::byte> out) const;

  /// Where a part of a kept print lies.
  struct Place {
    Descriptor file;
    std::uint64_t from = 0, bytes = 0;  ///< of the file
  };
  /// Errors as of read().
  [[nodiscard]] Expected<Place> find(std::uint32_t number, Part part) const;

 private:
  KeptPrints() = default;
  /// What became of a print that was written.
  struct Attempt {
    int problem = 0;          ///< errno; 0: it is durable
    std::uint64_t bytes = 0;  ///< that there was room for
  };
  Attempt write(KeptPrint& facts, FunctionRef<Status(TextSink&)> write, std::span<const std::byte> preview);
  Attempt write_new(KeptPrint& facts, FunctionRef<Status(TextSink&)> write, std::span<const std::byte> preview);
  bool make_room(std::uint64_t missing);
  void insert(const KeptPrint& print);
  void drop_oldest();
  std::uint64_t bytes() const;
  tl::unexpected<Error> cannot_write(int reason) const;

  FixedPath path_;
  Descriptor folder_;
  std::array<KeptPrint, kMost> list_;
  std::size_t count_ = 0;
  std::uint32_t newest_ = 0;  ///< the highest number there is, even if its print can't be read
};

}  // namespace plumbline::firmware
