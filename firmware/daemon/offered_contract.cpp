#include "firmware/daemon/offered_contract.hpp"

#include <utility>

#include "firmware/messages/printer_code.hpp"
#include "firmware/settings/print_values.hpp"

namespace plumbline {

OfferedContract::OfferedContract(std::string_view name, Contract& contract, PrintProfile& profile,
                                 std::function<Expected<Contract>(const PrintProfile&)> remake, StateRecorder& recorder)
    : name_(name),
      contract_(contract),
      profile_(profile),
      before_(profile),
      remake_(std::move(remake)),
      recorder_(recorder) {}

void OfferedContract::tell() const {
  recorder_.contracted(contract_);
  for_each_doubt(contract_, name_,
                 [this](const Told& told, std::string_view sentence) { recorder_.warn(sentence, told); });
}

Status OfferedContract::set(std::string_view key, std::string_view value) {
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
  const auto contract = remake_(changed_profile);
  PLUMBLINE_TRY(contract);
  profile_ = std::move(changed_profile);
  contract_ = *contract;
  recorder_.ask_about_other();
  tell();
  if (changed) changed();
  return {};
}

}  // namespace plumbline
