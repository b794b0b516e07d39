#pragma once
/// The settings of a job that can be changed with three buttons: a row each, whose value goes round.

#include <cstddef>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline::firmware::inline screen {

/// How many rows a job has: all, or, if it is an archive, only the profile.
/// @param record  with a job
std::size_t setting_rows(const PrinterRecord& record);
inline constexpr std::size_t kMostSettingRows = 7;

struct SettingRow {
  Words label;
  FixedText<64> value;
};

/// @param row  less than setting_rows(record)
SettingRow setting_row(std::size_t row, const PrinterRecord& record, Language language);

/// Whether a row's values are the best ways up, which are looked at before one is taken.
bool opens_proposals(std::size_t row);

/// The request that gives a row its next value.
/// @pre !opens_proposals(row)
ClientRequest next_value(std::size_t row, const PrinterRecord& record, const JobRecord& job);

/// A number with one to three digits behind the point: a comma in German.
FixedText<32> decimal(double value, int digits, Language language);

/// What raises or lowers a value of the contract by its step, within its range.
/// @pre the field can_be_changed()
ClientRequest changed_value(std::size_t field, const Contract& contract, bool up);

}  // namespace plumbline::firmware::inline screen
