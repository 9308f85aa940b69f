// tools/tune/pick.h: which choice suits a goal, on this disk and on others. It decides from
// measured figures only, so tests decide from made-up ones: tests/tools/tune/pick_test.cpp.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tune/choices.h"
#include "tune/disk_model.h"

namespace plait::tune {

enum class Goal : std::uint8_t { kRead, kWrite, kUpdate, kSize, kBalanced };
std::string_view to_string(Goal goal) noexcept;
const std::vector<Goal>& all_goals();
/// Errors: kInvalidArgument; the message lists the goals.
Goal goal_from_name(std::string_view name);

/// The same with another speed of the disk, for reading and for writing.
Machine with_speed(Machine machine, double bytes_per_second);

/// What a goal makes small: the seconds of a full read, of a full write, or of changing all records
/// in place (infinite if they cannot be changed); the stored bytes; or, balanced, the cube root of
/// read times write times bytes, so that a tenth of each counts the same.
double cost(Goal goal, const std::vector<Work>& works, const Machine& machine);
/// The processor time that counts for a goal: to decode, to encode, or both.
double processor_cost(Goal goal, const std::vector<Work>& works);

/// The logarithm of cost(a) / cost(b) with an interval of 95 %, from the parts of the sample that
/// both were measured on: M. H. Quenouille's jackknife. The interval is at least 1 % wide to each
/// side, because times are not more exact; a quarter, if both were measured on one part only. Reads
/// of two choices that were both probed (Trials::corrections) are not a matter of the sample: 3 %.
Figure compare(const Trials& trials, Goal goal, const Choice& a, const Choice& b,
               const Machine& machine);
/// Whether that interval contains equality.
bool no_difference(const Trials& trials, Goal goal, const Choice& a, const Choice& b,
                   const Machine& machine);

/// The choice of least cost. If it is not better than storing the blocks as they are, that.
/// REQUIRES: a pipeline of each attribute was measured.
Choice pick(const Trials& trials, Goal goal, const Machine& machine);

/// A choice on the front, and the speed from which on the next one takes less time.
struct FrontMember {
  Choice choice;
  std::optional<double>
      next_from;  ///< bytes a second; nothing for the last one, or if it never does
};
/// The choices with blocks of this size that no other one beats in stored bytes and in
/// processor_cost(), the smallest first.
std::vector<FrontMember> front_of(const Trials& trials, Goal goal, std::uint64_t block_bytes,
                                  const Machine& machine);

/// The best choice on disks of each speed.
struct SpeedRange {
  Choice choice;
  double slowest = 0, fastest = 0;  ///< bytes a second; 0 and infinity at the ends
};
/// From the slowest disks to the fastest. A range begins where the next choice is 2 % better, or
/// as much better as leaves no more than three ranges.
std::vector<SpeedRange> best_at_speeds(const Trials& trials, Goal goal, std::uint64_t block_bytes,
                                       const Machine& machine);
/// "For a full read: on disks slower than 900 MB/s choose A, else B."
std::string sentence(const Trials& trials, Goal goal, const std::vector<SpeedRange>& ranges);

}  // namespace plait::tune
