#include "slicer/reader/view_poses.hpp"

#include <algorithm>
#include <cmath>

#include "slicer/core/words/printable_text.hpp"
#include "slicer/reader/stream/line_input.hpp"
#include "slicer/reader/stream/number.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

std::string_view without_folder(std::string_view name) { return name.substr(name.rfind('/') + 1); }

std::optional<ScanPose> parse_pose(LineWords& words) {
  std::array<double, 7> numbers{};
  for (double& number : numbers) {
    const auto word = words.next();
    const char* const end = word.data() + word.size();
    if (word.empty() || parse_real(word.data(), end, number) != end || !std::isfinite(number)) return std::nullopt;
  }
  const auto& [tx, ty, tz, qx, qy, qz, qw] = numbers;
  const auto rotation = rotation_of(qw, qx, qy, qz);
  if (!rotation) return std::nullopt;
  return ScanPose{rotation->transpose(), {tx, ty, tz}};
}

}  // namespace

bool is_pose_file(std::string_view name) { return has_ending(name, ".conf"); }

bool has_pose_file(ScanSources sources) {
  return std::any_of(sources.begin(), sources.end(), [](const ByteSource* file) { return is_pose_file(file->name()); });
}

Expected<ViewPoses> ViewPoses::read(ScanSources sources, std::span<std::byte> workspace) {
  ViewPoses poses;
  const auto first =
      std::find_if(sources.begin(), sources.end(), [](auto* file) { return is_pose_file(file->name()); });
  const ScanSources scans(sources.begin(), first);
  poses.scans_ = scans.size();
  for (ByteSource* conf : ScanSources(first, sources.end())) {
    if (!is_pose_file(conf->name()) || scans.empty()) {
      return fail(ErrorCode::kBadSetting,
                  "%s says where scans lie and is none itself;\tgive the scans that it names, too, before it",
                  PrintableText((*first)->name()).c_str());
    }
    PLUMBLINE_TRY(poses.read_file(*conf, scans, workspace));
  }
  for (std::size_t i = 0; i < scans.size() && first != sources.end(); ++i) {
    if (poses.poses_[i]) continue;
    return fail(ErrorCode::kBadSetting,
                "%s: %s does not say where this scan lies;\tadd its line, or leave one of them out",
                PrintableText(scans[i]->name()).c_str(), PrintableText((*first)->name()).c_str());
  }
  return poses;
}

Status ViewPoses::read_file(ByteSource& conf, ScanSources scans, std::span<std::byte> workspace) {
  NoProgress progress;
  ByteInput input(conf, progress, workspace);
  LineInput lines(input);
  Line line;
  bool names_any = false;
  for (;;) {
    const auto found = lines.next(line);
    PLUMBLINE_TRY(found);
    if (!*found) break;
    if (input.bytes_read() > kMostPoseBytes) {
      return input.fail(ErrorCode::kMalformed,
                        "it has more than %zu bytes, so it gives no poses of scans;\tleave it out", kMostPoseBytes);
    }
    LineWords words(line.text);
    const auto keyword = words.next();
    if (keyword != "bmesh" && keyword != "mesh") continue;
    const auto name = without_folder(words.next());
    const auto at = std::find_if(scans.begin(), scans.end(),
                                 [&](const ByteSource* scan) { return without_folder(scan->name()) == name; });
    if (at == scans.end()) continue;
    names_any = true;
    auto& pose = poses_[static_cast<std::size_t>(at - scans.begin())];
    if (pose) {
      return input.fail(ErrorCode::kBadSetting, "line %llu: the second pose of '%s';\tkeep only one",
                        static_cast<unsigned long long>(lines.number()), Quote(name).c_str());
    }
    pose = parse_pose(words);
    if (pose) continue;
    return input.fail(
        ErrorCode::kMalformed,
        "line %llu: expected three numbers of a translation and four of a quaternion, found '%s';\tcorrect "
        "the line",
        static_cast<unsigned long long>(lines.number()), Quote(line.text).c_str());
  }
  if (names_any) return {};
  return input.fail(ErrorCode::kBadSetting, "it names none of the scans that are given with it;\tleave it out");
}

}  // namespace plumbline::inline slicer
