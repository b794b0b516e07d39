#include "firmware/slice/proof_report.hpp"

#include <algorithm>

#include "firmware/io/text/json_writer.hpp"

namespace plumbline::firmware {
namespace {

constexpr const char* kAdvice = "Look at the preview, check the normals of the scan, or scan more densely";

}  // namespace

FixedText<96> points_off_sentence(const PointProof& proof) {
  FixedText<96> text;
  text.add("%.3g %% of the points lie more than %.2g mm off what is printed", 100 * proof.share_off(),
           static_cast<double>(proof.reach_mm));
  return text;
}

FixedText<200> points_off_warning(const PointProof& proof) {
  FixedText<200> text;
  text.add("%s. %s", points_off_sentence(proof).c_str(), kAdvice);
  return text;
}

Status check_proof(const PointProof& proof, ScanSources sources) {
  if (proof.share_off() <= PointProof::kMost) return {};
  return telling(told_off(proof), fail(ErrorCode::kNoSurface, "%s: %s.\t%s", title_of(sources).c_str(),
                                       points_off_sentence(proof).c_str(), kAdvice));
}

FixedText<128> proven_text(const PointProof& proof) {
  const double all = std::max(1U, proof.points);
  FixedText<128> text;
  text.add("%.1f %% of the points lie within %.2g mm of what is printed, %.1f %% within a pixel",
           100 * (1 - proof.share_off()), static_cast<double>(proof.reach_mm), 100 * proof.within_pixel / all);
  return text;
}

void write_proof(JsonWriter& json, const PointProof& proof) {
  json.begin_object("proof", kOneLine);
  json.member("points", proof.points);
  json.member("within_pixel", proof.within_pixel);
  json.member("within_layer", proof.within_layer);
  json.member("off", proof.off);
  json.member("reach_mm", proof.reach_mm);
  json.end_object();
}

}  // namespace plumbline::firmware
