#include "slicer/reader/triangles/threemf/project_files.hpp"

#include <algorithm>
#include <array>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {

void complain_of_volumes(XmlParser& parser) {
  parser.complain("more than %zu negative volumes, modifiers, support enforcers and blockers",
                  ModelParts::kMostVolumes);
}

void ProjectDocument::begin(std::string_view name, const XmlAttributes& attributes) {
  ++depth_;
  if (depth_ == 2) {
    is_object_ = name == "object" && parse_number(attributes["id"], object_);
  } else if (depth_ == 3 && is_object_) {
    is_volume_ = name == "volume" || name == "part";
    volume_ = {.in = {0, object_}, .role = VolumeRole::kSolid};
    const bool has_range =
        parse_number(attributes["firstid"], volume_.first) && parse_number(attributes["lastid"], volume_.last);
    if (is_volume_ && !has_range && !parse_number(attributes["id"], volume_.child)) is_volume_ = false;
    see_type(attributes["subtype"]);
    const bool is_hollow = attributes["key"] == "hollowing_enable" && attributes["value"] == "1";
    if (name == "metadata" && is_hollow) project_.hollowing = true;
  } else if (depth_ == 4 && is_volume_ && name == "metadata") {
    if (attributes["key"] == "volume_type") see_type(attributes["value"]);
    if (attributes["key"] == "modifier" && attributes["value"] == "1") volume_.role = VolumeRole::kIgnored;
  }
}

void ProjectDocument::end(std::string_view /*name*/) {
  if (depth_ == 3 && is_volume_) {
    is_volume_ = false;
    if (volume_.role != VolumeRole::kSolid && !parts_.add(volume_)) complain_of_volumes(*parser_);
  }
  --depth_;
}

void ProjectDocument::see_type(std::string_view type) {
  if (type == "NegativeVolume" || type == "negative_part") volume_.role = VolumeRole::kNegative;
  constexpr std::array<std::string_view, 6> kIgnored = {"ParameterModifier", "SupportEnforcer",  "SupportBlocker",
                                                        "modifier_part",     "support_enforcer", "support_blocker"};
  if (std::ranges::find(kIgnored, type) != kIgnored.end()) volume_.role = VolumeRole::kIgnored;
}

void ProjectLines::read(std::span<const char> piece) {
  for (const char letter : piece) {
    if (letter == '\n') {
      end_line();
    } else {
      line_.append({&letter, 1});
    }
  }
}

void ProjectLines::end_line() {
  LineWords words(line_.view(), kXmlBlanks);
  auto key = words.next();
  if (key == ";") key = words.next();
  auto value = words.next();
  if (value == "=") value = words.next();
  has_list_ |= key.starts_with("object_id=");
  if (key == "hollowing_enable" && value == "1") project_.hollowing = true;
  double number = 0;
  if (key.starts_with("relative_correction") && value != "1" && value != "1,1" && value != "1,1,1") {
    project_.correction = true;
  }
  if (key == "absolute_correction" && parse_number(value, number) && number != 0) project_.correction = true;
  line_ = {};
}

}  // namespace plumbline::inline slicer
