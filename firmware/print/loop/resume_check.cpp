#include "firmware/print/loop/resume_check.hpp"

#include "firmware/messages/printer_code.hpp"
#include "slicer/core/words/plural.hpp"

namespace plumbline::firmware {

bool stage_confirms(const JournalEntry& last, const PrintPlan& plan, std::optional<ZPosition> found, Distance drift) {
  if (last.next_layer == plan.layers) return true;  // the plate is only raised
  if (!found) return false;
  // A quarter of a layer for the end stop and for rounding to steps.
  const Distance unsure = drift + Distance::nanometres(plan.layer_height.nanometres() / 4);
  // Where the layer after the next one is cured: from here on it could have been.
  const ZPosition too_high = height_of(plan, last.next_layer + 1);
  if (*found + unsure < too_high) return *found + unsure >= last.height;
  return last.stands >= too_high && *found + unsure >= last.stands && *found - unsure <= last.stands;
}

Spoken doubt_about(const JournalEntry& last, std::optional<ZPosition> found) {
  const double part_mm = last.height.above_film().millimetres();
  Spoken doubt;
  doubt.told = {PrinterCode::kCheckJournalDoubt, {{Fact::kHeightMm, part_mm}}};
  if (found) {
    doubt.text.add("the plate stood at %.2f mm, the journal ends at %.2f mm: measure the part",
                   found->above_film().millimetres(), part_mm);
  } else {
    doubt.text.add("it is not known where the plate stood, the journal ends at %.2f mm: measure the part", part_mm);
  }
  return doubt;
}

Spoken question_about(const JournalEntry& last) {
  const double part_mm = last.height.above_film().millimetres();
  Spoken question;
  if (last.next_layer == 0) {
    question.text.add(
        "no layer is cured yet. Look at the plate: press start if it is bare, cancel if a part hangs on it");
    question.told = PrinterCode::kLookAtPlate;
  } else {
    question.text.add(
        "the part must be %.2f mm tall (%u layer%s). Measure it: press start if it is, cancel if it is taller", part_mm,
        last.next_layer, plural_s(last.next_layer));
    question.told = {PrinterCode::kMeasurePart, {{Fact::kHeightMm, part_mm}, {Fact::kLayers, last.next_layer}}};
  }
  return question;
}

}  // namespace plumbline::firmware
