#include "firmware/child/scan_task.hpp"

#include <vector>

#include "firmware/child/given_file.hpp"
#include "firmware/child/rights.hpp"
#include "firmware/child/shared_progress.hpp"
#include "firmware/pictures/issue_picture.hpp"
#include "firmware/pictures/orientation_picture.hpp"
#include "firmware/print/job/sliced_scan.hpp"
#include "firmware/settings/job_options.hpp"
#include "firmware/slice/job_report.hpp"
#include "firmware/slice/orientation_proposals.hpp"
#include "slicer/cloud/cloud_reader.hpp"
#include "slicer/mesh_slicing.hpp"
#include "slicer/preparation.hpp"

namespace plumbline::firmware {
namespace {

void hand_back(const SlicedScan& sliced, const SliceReport& report, const Arena& arena, ScanAnswer& answer,
               std::span<const std::byte> block) {
  const auto place = [&block](const void* part) {
    return static_cast<std::uint64_t>(static_cast<const std::byte*>(part) - block.data());
  };
  answer.bottom_used = arena.bottom_used();
  answer.layers = sliced.rrep.grid.layers;
  answer.is_exact = sliced.rrep.is_exact ? 1 : 0;
  answer.steps = sliced.support_counts.steps;
  answer.crossings = sliced.rrep.packed.size();
  answer.first_at = place(sliced.rrep.first.data());
  answer.packed_at = place(sliced.rrep.packed.data());
  for (std::size_t i = 0; i < sliced.rrep.other_rays().size(); ++i) {
    const RRep& other = sliced.rrep.others[i];
    answer.other_rays[i] = {other.packed.size(), place(other.first.data()), place(other.packed.data())};
  }
  if (!sliced.supports.empty()) {
    answer.supports = static_cast<std::uint32_t>(sliced.supports.list.size());
    answer.supports_at = place(sliced.supports.list.data());
  }
  answer.scan_hash = sliced.scan_hash;
  answer.findings = sliced.findings;
  answer.proof = sliced.proof;
  for_each_remark(report, [&answer](const Told& told, std::string_view text) {
    if (answer.remarks == ScanAnswer::kMostRemarks) return;
    answer.remark_told[answer.remarks] = told;
    auto& remark = answer.remark[answer.remarks++];
    text.copy(remark.data(), remark.size() - 1);
  });
  answer.kind = ScanAnswer::kSliced;
}

/// Finds the best ways up and draws them.
Status propose(std::span<ByteSource* const> sources, const SliceSettings& asked, Arena& arena, ProgressSink& progress,
               MessagePage& page) {
  SliceSettings settings = set_threads(asked);
  settings.orient = false;
  settings.placement.rotation_degrees = Vec3d::Zero();
  PreparationReport report;
  const auto look = [&](const PreparedScan& scan, const SurfaceSamples& samples) -> Status {
    const auto proposals =
        propose_orientations(scan.cloud, samples, report.scan.header, asked, arena, {&progress, Stage::kNormals});
    PLUMBLINE_TRY(proposals);
    page.answer.proposals = *proposals;
    page.answer.kind = ScanAnswer::kProposals;
    std::array<std::array<double, 2>, kProposalCount> degrees;
    for (std::size_t i = 0; i < degrees.size(); ++i) degrees[i] = (*proposals)[i].degrees;
    // If the arena has no room for them, there are no pictures.
    static_cast<void>(draw_proposal_pictures(scan.cloud, degrees, arena, page.proposals));
    return {};
  };
  return prepare_normals(sources, settings, arena, &progress, report, look);
}

/// Reads a scan or a mesh in few points and draws it.
Status glance(std::span<ByteSource* const> sources, const SliceSettings& settings, Arena& arena, ProgressSink& progress,
              MessagePage& page) {
  StageMemory memory;
  const StageContext job{arena, &progress, memory};
  const auto draw = [&](const Cloud& cloud) -> Status {
    if (cloud.size == 0) return fail(ErrorCode::kNoPoints, "there are no points");
    PLUMBLINE_TRY(draw_scan_picture(cloud, arena, page.glance));
    page.answer.kind = ScanAnswer::kGlance;
    return {};
  };
  const auto of_mesh = [&](MeshFiles& files, const SurveyedMesh& mesh, ScanSources) -> Status {
    const auto cloud = mesh_cloud(files, mesh.survey, job);
    PLUMBLINE_TRY(cloud);
    return draw(*cloud);
  };
  const auto of_scan = [&](ScanSources given) -> Status {
    // A picture of 64 x 64 pixels shows no more points.
    const auto room = [](const ScanAnnouncement&) -> Expected<std::uint32_t> { return 1U << 15U; };
    const auto read = read_cloud(given, {}, room, arena, &progress);
    PLUMBLINE_TRY(read);
    return draw(read->cloud);
  };
  return read_mesh_or_scan(sources, settings, job, of_mesh, of_scan);
}

}  // namespace

void hand_back_error(const Error& error, ScanAnswer& answer) {
  answer.code = static_cast<std::uint32_t>(error.code());
  answer.advice_at = static_cast<std::uint32_t>(error.advice().empty() ? 0 : error.advice().data() - error.message());
  std::string_view(error.message()).copy(answer.message.data(), answer.message.size() - 1);
  answer.told = error.told();
  answer.kind = ScanAnswer::kRefused;
}

void refuse_without_filter(ScanAnswer& answer) {
  hand_back_error(Error::format(ErrorCode::kUnsupported, "this kernel has no seccomp filters"), answer);
}

void run_scan_task(SharedMemory& memory, std::uint32_t threads) {
  start_threads(threads);
  MessagePage& page = memory.page();
  if (!filter_system_calls()) return refuse_without_filter(page.answer);
  Arena arena(memory.arena());
  std::vector<GivenFile> files;
  for (const RequestedFile& file : page.request.files()) files.emplace_back(static_cast<int>(files.size()), file);
  std::vector<ByteSource*> sources;
  sources.reserve(files.size());
  for (GivenFile& file : files) sources.push_back(&file);
  SharedProgress progress(page.progress);
  if (page.request.proposes || page.request.is_glance) {
    const auto& task = page.request.proposes ? propose : glance;
    const Status done = task(sources, page.request.settings, arena, progress, page);
    if (!done) hand_back_error(done.error(), page.answer);
    return;
  }
  SliceReport report;
  const auto sliced = slice_for_print(sources, page.request.settings, arena, &progress, report);
  if (sliced) {
    hand_back(*sliced, report, arena, page.answer, memory.arena());
    // If the arena has no room for them, the job has no pictures.
    static_cast<void>(draw_preview_picture(sliced->rrep, sliced->supports, arena, page.pictures.preview));
    static_cast<void>(
        draw_issues_picture(sliced->findings, sliced->rrep, sliced->supports, arena, page.pictures.issues));
    // Of a mesh all is known.
    static_cast<void>(make_part_model(sliced->rrep, sliced->supports, report.mesh ? ConfidenceMap() : report.confidence,
                                      arena, page.pictures.part));
  } else {
    hand_back_error(sliced.error(), page.answer);
  }
}

}  // namespace plumbline::firmware
