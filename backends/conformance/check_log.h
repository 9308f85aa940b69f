// backends/conformance/check_log.h: what a check of the conformance suite has found.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plait::conformance {

/// Ends a check. The log has the reason.
struct CheckEnded {};

/// One thread at a time.
class CheckLog {
 public:
  /// Records that `promise`, a sentence about the backend, was not true.
  void expect(bool held, std::string_view promise) {
    if (held) return;
    ++broken_count_;
    std::string sentence(promise);
    if (!place_.empty()) sentence += " (" + place_ + ")";
    if (broken_.size() < kMostKept && (broken_.empty() || broken_.back() != sentence))
      broken_.push_back(std::move(sentence));
  }
  /// The same, and ends the check, because the rest of it makes no sense then.
  void require(bool held, std::string_view promise) {
    expect(held, promise);
    if (!held) throw CheckEnded();
  }
  /// Says where in the check the next expectations are: a size, a content.
  void at(std::string place) { place_ = std::move(place); }
  /// Says that the check could not be made on this backend, and why.
  void leave_out(std::string reason) { left_out_ = std::move(reason); }

  /// Says how much was checked.
  void note(std::string what) { note_ = std::move(what); }

  bool held() const { return broken_count_ == 0; }
  std::size_t broken_count() const { return broken_count_; }
  /// The first sentences that were not true. A sentence that follows itself is there once.
  const std::vector<std::string>& broken() const { return broken_; }
  const std::string& note() const { return note_; }
  /// Empty if the check was made.
  const std::string& left_out() const { return left_out_; }

 private:
  static constexpr std::size_t kMostKept = 10;

  std::size_t broken_count_ = 0;
  std::vector<std::string> broken_;
  std::string place_, left_out_, note_;
};

}  // namespace plait::conformance
