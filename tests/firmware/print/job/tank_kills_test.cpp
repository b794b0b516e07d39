/// The firmware is killed 200 times over prints in a row, with tanks of 1 to 5 ml: at any instant of a print, and at any call on a file.
/// Each process starts as the printer does, and whoever is asked fills the tank to what was asked for. What the plant has cured is
/// counted in memory that outlives the processes.

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <random>

#include "firmware/print/job/machine_record.hpp"
#include "firmware/print/job/printable.hpp"
#include "firmware/print/print_session.hpp"
#include "hal/sim/sim_machine.hpp"
#include "tests/firmware/support/failing_calls.hpp"
#include "tests/hil/session_rig.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::uint32_t kTowerLayers = 40;
constexpr double kTowerPitchMm = 0.4;
constexpr double kTowerLayerMm = 0.05;
constexpr double kTowerPixelMl = kTowerPitchMm * kTowerPitchMm * kTowerLayerMm / 1000;

/// What is true, whatever the firmware believes.
struct Truth {
  std::array<std::uint64_t, kTowerLayers> lit_pixels;  ///< of the print at hand, by layer
  double cured_ml;                                     ///< of the prints before
  double filled_ml, cured_when_filled_ml;
  bool is_filling;       ///< the resin is in, the answer is not in the record yet
  double plate_mm;       ///< where it stands
  std::uint32_t prints;  ///< finished
  std::uint32_t questions;

  double cured() const {
    double ml = cured_ml;
    for (const std::uint64_t pixels : lit_pixels) ml += static_cast<double>(pixels) * kTowerPixelMl;
    return ml;
  }
  double in_tank_ml() const { return filled_ml - (cured() - cured_when_filled_ml); }
};

/// Fills the tank to what is asked for, and presses start.
class Filler final : public RigUser {
 public:
  Filler(Plant& plant, Truth& truth) : RigUser(plant), truth_(truth) {
    on_update = [this](const PrintStatus& status) {
      const bool asked = status.state == PrintState::kFeedMe;
      if (asked && !truth_.is_filling) {
        ++truth_.questions;
        for (std::size_t i = 0; i < status.question_told.count; ++i) {
          if (status.question_told.facts[i] == static_cast<Fact>(PrinterFact::kFillMl)) {
            truth_.is_filling = true;
            truth_.filled_ml = std::max(truth_.in_tank_ml(), status.question_told.values[i]);
            truth_.cured_when_filled_ml = truth_.cured();
          }
        }
      }
      if (!asked && status.state == PrintState::kPrinting) truth_.is_filling = false;
    };
  }

 private:
  Truth& truth_;
};

BoardFile tower_board() {
  BoardFile board = session_board();
  board.pixel_pitch_x_mm = board.pixel_pitch_y_mm = kTowerPitchMm;
  return board;
}

/// How a process ends, if its print does not.
struct Kill {
  nanoseconds after{};     ///< of plant time; 0: not by time
  std::uint32_t call = 0;  ///< at this call on a file; 0: at none
};

class TankKills : public ::testing::Test {
 protected:
  TankKills()
      : truth_(*static_cast<Truth*>(
            ::mmap(nullptr, sizeof(Truth), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {}
  ~TankKills() override { ::munmap(&truth_, sizeof truth_); }

  /// A process of the firmware, from its start to the end of a print or its own.
  void live(double tank_ml, const Kill& kill) {
    const TowerRRep tower(kTowerLayers);
    RRep rrep = tower.rrep();
    rrep.grid.pitch_x_mm = rrep.grid.pitch_y_mm = static_cast<float>(kTowerPitchMm);
    const BoardFile board = tower_board();
    MachineFile machine = rig_machine();
    machine.tank_volume_ml = tank_ml;
    auto store = JobStore::open(folder_ / "state");
    PlantSettings settings = plant_for(board);
    settings.pace.computing = 0;
    settings.keep_part = false;
    if (const auto progress = store->progress()) {
      settings.layers_on_plate = progress->last.next_layer;
      settings.height_on_plate = progress->last.height;
    }
    settings.stage.start = Distance::millimetres(truth_.plate_mm);
    Plant plant(settings);
    const FailingCall call(Calls::kAll, kill.call, Failure::kKilled);
    if (kill.after > nanoseconds()) {
      plant.timeline().at(TimePoint() + kill.after, [&] {
        look(plant);
        ::kill(::getpid(), SIGKILL);
      });
    }
    std::function<void()> looking = [&] {
      look(plant);
      plant.timeline().at(plant.now() + std::chrono::milliseconds(20), looking);
    };
    looking();
    auto record = open_machine_record(folder_ / "state", *store, tank_ml, false);
    SimMachine run(plant);
    Machine devices = run.machine();
    Filler user(plant, truth_);
    Arena arena(block_);
    PrintSession session(board, machine, arena, &*store);
    const auto interrupted = has_interrupted_print(*store, *record);
    if (!interrupted) ::_exit(4);
    if (*interrupted) {
      if (!session.load()) ::_exit(5);
    } else {
      SlicedScan sliced{.rrep = rrep, .supports = {}, .support_counts = {}, .findings = {}};
      sliced.findings.first_layer_pixels = 40 * 42;
      sliced.findings.voxels = tower.pixels();
      const PrintProfile profile = rig_profile();
      const auto contract = contract_of(sliced, {}, profile, machine);
      if (!contract || !session.take(printable_of(sliced, "tower", profile.name, *contract))) ::_exit(6);
    }
    const PrintReport& report = session.print(devices, user, &*record);
    look(plant);
    if (report.state != PrintState::kFinished) ::_exit(7);
    truth_.cured_ml = truth_.cured();
    truth_.lit_pixels = {};
    ++truth_.prints;
    static_cast<void>(record->confirm_empty());
    ::_exit(0);
  }

  /// Writes down what has had light. A layer that is lit again at its height is the same resin.
  void look(Plant& plant) {
    truth_.plate_mm = plant.stage().height().millimetres();
    const auto note = [&](Distance height, std::uint64_t pixels) {
      const auto layer = std::llround(height.millimetres() / kTowerLayerMm) - 1;
      if (layer < 0 || layer >= kTowerLayers) return;
      std::uint64_t& known = truth_.lit_pixels[static_cast<std::size_t>(layer)];
      known = std::max(known, pixels);
    };
    for (const CuredLayer& layer : plant.part().layers()) note(layer.z.above_film(), layer.pixels);
    if (plant.light()) note(plant.stage().height(), plant.panel().visible().count());
  }

  /// @returns whether it was killed
  bool run_and_kill(double tank_ml, const Kill& kill) {
    const pid_t child = ::fork();
    if (child == 0) live(tank_ml, kill);
    int status = -1;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    const bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
    EXPECT_TRUE(killed || (WIFEXITED(status) && WEXITSTATUS(status) == 0)) << status;
    return killed;
  }

  TemporaryFolder folder_;
  Truth& truth_;
  alignas(Arena::kAlignment) std::array<std::byte, std::size_t{4} << 20U> block_{};
};

TEST_F(TankKills, LeaveTheResinInTheRecordWithinAFiftiethOfAMillilitreAndNeverMoreThanThereIs) {
  std::mt19937_64 random(52);
  std::uint32_t kills = 0, prints = 0, questions = 0, known = 0;
  double worst_ml = 0;
  for (const double tank_ml : {1.0, 2.0, 3.0, 5.0}) {
    std::filesystem::remove_all(folder_ / "state");
    truth_ = {};
    truth_.plate_mm = 60;
    for (std::uint32_t of_tank = 0; of_tank < 50 && !HasFailure();) {
      SCOPED_TRACE(testing::Message() << "tank of " << tank_ml << " ml, kill " << of_tank);
      Kill kill;
      if (random() % 3 == 0) {
        kill.call = 1 + static_cast<std::uint32_t>(random() % 300);
      } else {
        kill.after = std::chrono::milliseconds(1 + random() % 500'000);
      }
      of_tank += run_and_kill(tank_ml, kill) ? 1 : 0;
      const auto store = JobStore::open(folder_ / "state");
      const auto record = open_machine_record(folder_ / "state", *store, tank_ml, false);
      ASSERT_TRUE(record) << record.error().message();
      const auto left = record->resin_ml();
      if (!left) {
        EXPECT_EQ(truth_.cured(), 0) << "nobody has said, so nothing was cured";
        continue;
      }
      ++known;
      EXPECT_LE(*left, truth_.in_tank_ml() + 1e-9) << "more than there is";
      if (truth_.is_filling) continue;
      worst_ml = std::max(worst_ml, truth_.in_tank_ml() - *left);
      EXPECT_NEAR(*left, truth_.in_tank_ml(), 0.02);
    }
    kills += 50;
    prints += truth_.prints;
    questions += truth_.questions;
  }
  std::printf("%u kills, %u prints finished, %u times filled, the record lacked %.4f ml at most\n", kills, prints,
              questions, worst_ml);
  EXPECT_GT(prints, 20U);
  EXPECT_GT(questions, 10U);
  EXPECT_GT(known, 150U);
}

}  // namespace
}  // namespace plumbline::firmware
