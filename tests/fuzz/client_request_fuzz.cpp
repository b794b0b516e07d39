/// Any bytes as a request to the state socket: refused with a reason, or within its bounds.

#include <cstdint>
#include <string_view>

#include "firmware/io/text/json_cursor.hpp"
#include "firmware/state/client_request.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace plumbline;
  using namespace plumbline::firmware;
  using namespace plumbline::firmware::fuzz;
  const std::string_view line(reinterpret_cast<const char*>(bytes), size);
  std::optional<std::uint64_t> id;
  const auto request = parse_request(line, id);
  JsonCursor cursor(line);
  const bool is_json = cursor.take_value(1) && cursor.at_end();
  if (!request) {
    require(request.error().code() == ErrorCode::kMalformed || request.error().code() == ErrorCode::kBadSetting,
            "another kind of error");
    require(!request.error().finding().empty(), "an error without a reason");
    return 0;
  }
  require(is_json, "a request that is no JSON");
  require(json_member(line, "do").has_value(), "a request without a command");
  require((request->scan > 0) == (request->command == Command::kChoose), "a scan that nobody chose");
  require(request->scan <= PrinterRecord::kMostScans, "a scan that no list has");
  require(request->key.view().empty() || request->command == Command::kSet, "a key that nobody set");
  require(!id || *id <= (std::uint64_t{1} << 53U), "an id that JSON can't hold");
  return 0;
}
