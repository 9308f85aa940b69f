// Sorts records that do not fit into memory: runs are sorted in memory, on all threads, and then
// merged by a tree of losers.
#pragma once

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/threads.h"
#include "layout/temporary_file.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Which of several sorted sequences has the smallest record. Of equal records, that of the first
/// sequence comes first.
template <class Record>
class LoserTree {
 public:
  /// REQUIRES: at least one sequence.
  explicit LoserTree(std::vector<SequentialReader<Record>> sequences)
      : sequences_(std::move(sequences)),
        leaves_(std::bit_ceil(sequences_.size())),
        heads_(leaves_),
        losers_(leaves_) {
    for (std::size_t at = 0; at < sequences_.size(); ++at) advance(at);
    winner_ = play(1);
  }

  bool next(Record& record) {
    if (heads_[winner_].ended) return false;
    record = heads_[winner_].record;
    advance(winner_);
    for (std::size_t node = (leaves_ + winner_) / 2; node > 0; node /= 2)
      if (is_before(losers_[node], winner_)) std::swap(losers_[node], winner_);
    return true;
  }

 private:
  struct Head {
    Record record{};
    bool ended = true;
  };

  void advance(std::size_t sequence) {
    heads_[sequence].ended = !sequences_[sequence].next(heads_[sequence].record);
  }
  bool is_before(std::size_t a, std::size_t b) const {
    if (heads_[a].ended || heads_[b].ended) return !heads_[a].ended;
    if (heads_[a].record < heads_[b].record) return true;
    return !(heads_[b].record < heads_[a].record) && a < b;
  }
  /// The winner of a part of the tree whose losers it sets.
  std::size_t play(std::size_t node) {
    if (node >= leaves_) return node - leaves_;
    const std::size_t left = play(2 * node), right = play(2 * node + 1);
    const bool right_wins = is_before(right, left);
    losers_[node] = right_wins ? left : right;
    return right_wins ? right : left;
  }

  std::vector<SequentialReader<Record>> sequences_;
  std::size_t leaves_;
  std::vector<Head> heads_;          ///< [sequence]; those beyond have ended
  std::vector<std::size_t> losers_;  ///< [node]
  std::size_t winner_ = 0;
};

/// Of one sort: `bytes` while records are pushed, and again while they are read.
struct SortMemory {
  std::uint64_t bytes = 0;
  /// What is read of a run at once, at least. As many runs are merged at once as fit.
  std::uint64_t read_bytes = std::uint64_t{256} << 10;
};

/// The most disk that a sort of `records` takes at a time. One that merges in more than one
/// pass may have all of them twice.
inline std::uint64_t disk_of_sort(std::uint64_t records, std::size_t record_bytes,
                                  SortMemory memory) {
  const std::uint64_t bytes = records * record_bytes;
  if (bytes <= memory.bytes) return 0;
  const std::uint64_t runs = bytes / std::max<std::uint64_t>(1, memory.bytes) + 1,
                      at_once = std::max<std::uint64_t>(
                          2, memory.bytes / std::max<std::uint64_t>(1, memory.read_bytes));
  return runs > at_once ? 2 * bytes : bytes;
}

/// Records are pushed in any order, and then come in ascending order, once.
template <class Record>
class ExternalSort {
  static_assert(std::is_trivially_copyable_v<Record>);

 public:
  /// The directory outlives the object.
  ExternalSort(const Directory& in, SortMemory memory)
      : in_(&in), memory_(memory), most_(std::max<std::size_t>(2, memory.bytes / sizeof(Record))) {}
  ExternalSort(const ExternalSort&) = delete;
  ExternalSort& operator=(const ExternalSort&) = delete;

  void push(const Record& record) {
    if (run_.size() == most_) write_run();
    if (run_.capacity() == 0) run_.reserve(most_);  // pages that are not used take no memory
    run_.push_back(record);
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  /// How many runs were written and merged, in all passes; 0: the records fit into memory.
  std::uint64_t merged_runs() const { return merged_runs_; }

  /// Ends the pushing.
  void sort() {
    if (runs_.empty()) return sort_run();
    write_run();
    std::vector<Record>().swap(run_);  // an assignment would keep the memory
    while (runs_.size() > fan_in()) merge_some();
    merged_runs_ += runs_.size();
  }
  /// Returns false at the end. REQUIRES: sort() was called.
  bool next(Record& record) {
    // Not before the first call: a sort that waits has no buffers.
    if (!merge_ && !runs_.empty())
      merge_ = std::make_unique<LoserTree<Record>>(readers_of(runs_.size()));
    if (merge_) return merge_->next(record);
    if (at_ == run_.size()) return false;
    record = run_[at_++];
    return true;
  }

 private:
  struct Run {
    std::shared_ptr<File> file;
    std::uint64_t offset, count;
  };

  std::size_t fan_in() const {
    return std::max<std::size_t>(2, memory_.bytes / std::max<std::uint64_t>(1, memory_.read_bytes));
  }
  void sort_run() {
    on_workers([&] { tbb::parallel_sort(run_.begin(), run_.end()); });
  }
  void write_run() {
    sort_run();
    if (!file_) file_ = std::make_shared<File>(temporary_file(*in_));
    file_->write_at(end_, std::as_bytes(std::span(run_)));
    runs_.push_back({file_, end_, run_.size()});
    end_ += run_.size() * sizeof(Record);
    run_.clear();
  }
  /// Of the first `count` runs.
  std::vector<SequentialReader<Record>> readers_of(std::size_t count) const {
    std::vector<SequentialReader<Record>> readers;
    for (std::size_t at = 0; at < count; ++at)
      readers.emplace_back(*runs_[at].file, runs_[at].offset, runs_[at].count,
                           memory_.bytes / count);
    return readers;
  }
  /// Makes one run of the first ones, and puts it behind the others: so all of them are merged
  /// before one is merged again.
  void merge_some() {
    const std::size_t count = std::min(fan_in(), runs_.size());
    const auto file = std::make_shared<File>(temporary_file(*in_));
    std::uint64_t records = 0;
    {
      SequentialWriter writer(*file, 0, std::max<std::size_t>(memory_.read_bytes, sizeof(Record)));
      LoserTree<Record> merge(readers_of(count));
      for (Record record; merge.next(record); ++records)
        writer.put(std::as_bytes(std::span(&record, 1)));
      writer.flush();
    }
    runs_.erase(runs_.begin(), runs_.begin() + static_cast<std::ptrdiff_t>(count));
    runs_.push_back({file, 0, records});
    merged_runs_ += count;
    file_.reset();
  }

  const Directory* in_;
  SortMemory memory_;
  std::size_t most_;
  std::vector<Record> run_;
  std::size_t at_ = 0;  ///< in a run that stays in memory
  std::shared_ptr<File> file_;
  std::uint64_t end_ = 0, count_ = 0, merged_runs_ = 0;
  std::vector<Run> runs_;
  std::unique_ptr<LoserTree<Record>> merge_;
};

PLAIT_END_NAMESPACE
