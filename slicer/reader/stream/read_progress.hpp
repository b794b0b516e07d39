#pragma once
/// Progress and cancellation of reading a file.

namespace plumbline::inline slicer {

class ReadProgress {
 public:
  virtual ~ReadProgress() = default;
  /// @param fraction  of the file, 0 to 1; 0 while its size is unknown
  /// @returns false to cancel
  virtual bool progress(double fraction) = 0;
};

/// For what is too short to be cancelled.
class NoProgress final : public ReadProgress {
 public:
  bool progress(double /*fraction*/) override { return true; }
};

}  // namespace plumbline::inline slicer
