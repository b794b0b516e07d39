#pragma once
/// The settings of a job that can be changed with three buttons: a row each, whose value goes round.

#include <cstddef>

#include "firmware/io/fixed_text.hpp"
#include "firmware/screen/words.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline {

inline constexpr std::size_t kSettingRowCount = 7;

struct SettingRow {
  Words label;
  FixedText<64> value;
};

/// @param row  less than kSettingRowCount
/// @param job  what is offered
SettingRow setting_row(std::size_t row, const JobRecord& job, Language language);

/// The request that gives a row its next value.
ClientRequest next_value(std::size_t row, const PrinterRecord& record, const JobRecord& job);

/// A number with one to three digits behind the point: a comma in German.
FixedText<32> decimal(double value, int digits, Language language);

}  // namespace plumbline
