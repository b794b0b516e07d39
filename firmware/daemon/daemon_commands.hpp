#pragma once
/// Carries out what the clients of the state socket, and the printer's own screen, ask of the daemon.

#include <functional>
#include <string>
#include <string_view>

#include "firmware/daemon/answers.hpp"
#include "firmware/daemon/offered_contract.hpp"
#include "firmware/daemon/offered_masks.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/daemon/stick_offer.hpp"
#include "firmware/daemon/upload/uploads.hpp"
#include "firmware/print/job/machine_record.hpp"
#include "firmware/state/printer_record.hpp"
#include "firmware/state/state_socket.hpp"

namespace plumbline::firmware {

class DaemonCommands final : public CommandTaker {
 public:
  /// All must outlive it.
  /// @param machine      gets what people say of the tank
  /// @param report_path  of the last print's report
  DaemonCommands(const PrinterRecord& record, StateRecorder& observer, Answers& answers, MachineRecord& machine,
                 Uploads& uploads, const std::string& report_path)
      : record_(record),
        observer_(observer),
        answers_(answers),
        machine_(machine),
        uploads_(uploads),
        report_path_(report_path) {}

  /// Called while the daemon waits for an event. A command that answers a question becomes the button that does.
  Expected<std::optional<EventKind>> take(const ClientRequest& request) override;
  Expected<bool> draw_mask(std::uint32_t layer, const MaskWindow& window, MaskPicture& picture) override;
  Expected<std::uint32_t> take_upload(const ClientRequest& upload, Descriptor from) override;
  Expected<ReportPart> read_report(std::uint64_t from, std::span<std::byte> out) override;

  StickOffer* offer = nullptr;          ///< that somebody is asked about; null: none
  OfferedContract* contract = nullptr;  ///< the same, of what has been sliced
  OfferedMasks* masks = nullptr;        ///< of the same
  /// Takes the job that was sliced back to its settings, or changes one and has it sliced again.
  /// @param request  settings, or set
  /// @returns whether that ends the question; false: the setting is what it was
  std::function<Expected<bool>(const ClientRequest& request)> again;
  bool of_upload = false;  ///< what is offered was uploaded

 private:
  Expected<bool> change_sliced(const ClientRequest& request);
  Expected<std::optional<EventKind>> fill_tank(std::optional<double> ml);
  Expected<std::optional<EventKind>> remove_upload(std::string_view name);

  const PrinterRecord& record_;
  StateRecorder& observer_;
  Answers& answers_;
  MachineRecord& machine_;
  Uploads& uploads_;
  const std::string& report_path_;
};

}  // namespace plumbline::firmware
