#include "firmware/io/job_progress.hpp"

#include "firmware/io/interrupt.hpp"

namespace plumbline::firmware {

void JobProgress::begin(Stage stage) {
  begun_ = Clock::now();
  if (display_ != nullptr) display_->begin(stage);
}

bool JobProgress::advance(Stage stage, double fraction) {
  if (interrupted()) return false;
  if (display_ != nullptr) display_->update(stage, fraction, since(begun_));
  return true;
}

void JobProgress::end(Stage stage, std::size_t peak_bytes) {
  const double seconds = since(begun_);
  seconds_[static_cast<std::size_t>(stage)] = seconds;
  if (display_ != nullptr) display_->end(stage, seconds, peak_bytes);
}

double JobProgress::total_seconds() const { return since(made_); }

}  // namespace plumbline::firmware
