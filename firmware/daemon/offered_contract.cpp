#include "firmware/daemon/offered_contract.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/settings/print_values.hpp"

namespace plumbline::firmware {

OfferedContract::OfferedContract(std::string_view name, Contract& contract, PrintProfile& profile,
                                 const PrintProfile& before,
                                 std::function<Expected<Contract>(const PrintProfile&)> remake, StateRecorder& recorder)
    : name_(name),
      contract_(contract),
      profile_(profile),
      before_(before),
      remake_(std::move(remake)),
      recorder_(recorder) {}

void OfferedContract::tell() const {
  recorder_.contracted(contract_);
  for_each_doubt(contract_, name_,
                 [this](const Told& told, std::string_view sentence) { recorder_.warn(sentence, told); });
}

Expected<bool> OfferedContract::ask(std::string_view found, Answers& answers) {
  put_ = [this, found] {
    FixedText<512> text;
    for_each_doubt(contract_, name_, [&text](const Told&, std::string_view sentence) {
      text.add("%.*s. ", static_cast<int>(sentence.size()), sentence.data());
    });
    if (!found.empty()) text.add("Found in the layers: %.*s. ", static_cast<int>(found.size()), found.data());
    const bool doubtful = !text.view().empty();
    if (!doubtful) text.add("%s. ", size_line(contract_).c_str());
    text.add("Press start to print it%s, or cancel", doubtful ? " all the same" : "");
    recorder_.say(text.view());
  };
  answers.put();
  put_();
  while (!answers.shutdown()) {
    const auto answer = answers.ask();
    PLUMBLINE_TRY(answer);
    if (*answer == EventKind::kStartPressed) return true;
    if (*answer == EventKind::kCancelPressed) break;
  }
  return false;
}

bool OfferedContract::takes(std::string_view key) const {
  const PrintField* const field = find_print_field(key);
  return contract_.is_archive || (field != nullptr && field->can_be_changed());
}

Expected<bool> OfferedContract::set(std::string_view key, std::string_view value) {
  const PrintField* const field = find_print_field(key);
  if (field == nullptr || !field->can_be_changed()) {
    return telling(Told(PrinterCode::kSettingUnknown, {}, key),
                   fail(ErrorCode::kBadSetting,
                        "'%.*s': can't be changed once the layers are made.\tDecline the print to change it",
                        static_cast<int>(key.size()), key.data()));
  }
  const auto number = parse_print_value(*field, value);
  PLUMBLINE_TRY(number);
  PrintProfile changed_profile = profile_;
  if (*number) {
    set_value(changed_profile, *field, **number, ValueSource::kPerson);
  } else {
    set_value(changed_profile, *field, value_of(before_, *field), before_.sources[index_of(field->key)]);
  }
  const std::size_t which = index_of(field->key);
  const bool is_other = value_of(changed_profile, *field) != value_of(profile_, *field);
  if (!is_other && changed_profile.sources[which] == profile_.sources[which]) return false;
  const auto contract = remake_(changed_profile);
  PLUMBLINE_TRY(contract);
  profile_ = std::move(changed_profile);
  contract_ = *contract;
  recorder_.ask_about_other();
  tell();
  if (put_) put_();
  return is_other && shapes_layers(field->key);
}

bool OfferedContract::shapes_layers(PrintKey key) const {
  using enum PrintKey;
  if (contract_.is_archive || !profile_.exchange) return false;
  constexpr std::array kLight = {kExposureTime, kInitialExposureTime, kBottomLayerCount, kFadedLayers};
  return std::ranges::find(kLight, key) != kLight.end();
}

}  // namespace plumbline::firmware
