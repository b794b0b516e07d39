#pragma once

#include <functional>
#include <string_view>

#include "firmware/daemon/answers.hpp"
#include "firmware/daemon/state_recorder.hpp"
#include "firmware/print/job/contract.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// The contract that a person is asked about. Until they accept it, they may change what needs no new masks: exposures, bottom layers,
/// lifts and waits.
class OfferedContract {
 public:
  /// All must outlive it.
  /// @param name      of what is printed
  /// @param contract  of the profile; what people accept is in it
  /// @param profile   gets the person's values
  /// @param before    the profile without them
  /// @param remake    makes the contract of a changed profile
  OfferedContract(std::string_view name, Contract& contract, PrintProfile& profile, const PrintProfile& before,
                  std::function<Expected<Contract>(const PrintProfile&)> remake, StateRecorder& recorder);

  /// Shows the contract, and says what is doubtful about it.
  void tell() const;
  /// Asks a person whether to print it, with what is doubtful about it.
  /// @param found  what the checks have found in its layers; empty: nothing to ask about
  /// @returns false: it was declined, or the system shuts down
  [[nodiscard]] Expected<bool> ask(std::string_view found, Answers& answers);

  /// Whether set() takes a key: all others need new layers, which an archive can't have.
  bool takes(std::string_view key) const;
  /// Changes a value. "" sets it back to what it was before any person changed it.
  /// @returns whether the layers were made for another one: how far undersides are raised follows from the light
  /// @retval ErrorCode::kBadSetting  no such value, or out of range, or the printer can't do it; nothing has changed
  [[nodiscard]] Expected<bool> set(std::string_view key, std::string_view value);

 private:
  bool shapes_layers(PrintKey key) const;

  std::string_view name_;
  Contract& contract_;
  PrintProfile& profile_;
  const PrintProfile& before_;
  std::function<Expected<Contract>(const PrintProfile&)> remake_;
  StateRecorder& recorder_;
  std::function<void()> put_;  ///< repeats the question; empty until it is asked
};

}  // namespace plumbline::firmware
