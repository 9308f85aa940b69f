// tools/tune/disk_model.h: how long a store takes on a disk, computed from what it stores and from
// what its pipelines need of the processor. docs/tune.md has the formulas.
// Pinned by tests/tools/tune/disk_model_test.cpp, in closed form.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tune/figures.h"

namespace plait::tune {

/// What a disk does in blocks of one size.
struct BlockRate {
  double block_bytes = 0;
  double read = 0, write = 0;  ///< bytes a second
};

/// A disk, as a store's files see it. Rates are bytes a second.
struct Disk {
  std::string name;
  double read = 0, write = 0;             ///< long runs, cold and durable
  double burst_bytes = 0;                 ///< after a pause the disk reads so many faster
  double burst_read = 0;                  ///< how fast
  double latency = 0;                     ///< seconds until the first byte of a random read comes
  double random_read = 0;                 ///< then, bytes of one random read a second
  double unwritten_bytes = 0;             ///< the system holds so much before it begins to write
  std::vector<BlockRate> of_blocks = {};  ///< ascending by size; empty: the same for all sizes
  bool is_measured = false;
};
/// Disks as they are sold, and memory.
std::vector<Disk> classes_of_disks();

/// The rates for blocks of this size: between two measured sizes on a line over the logarithm of
/// the size, beyond them those of the nearest.
BlockRate rate_of(const Disk& disk, double block_bytes);

/// Seconds to read the bytes from `before` to `before + bytes` of a run without a pause, in blocks
/// of this size.
double seconds_to_read(const Disk& disk, double block_bytes, double before, double bytes);

/// What a disk reads faster after a pause, and how fast; 0: there is no burst.
struct Burst {
  double bytes = 0, rate = 0;
};
/// From the seconds of parts of a run of `bytes`. Halves that differ by less than a quarter show no
/// burst.
Burst burst_of(double bytes, double first_sixteenth_seconds, double first_half_seconds,
               double second_half_seconds);

/// How the times of the disk and of the processors add up in a read: factor * (the longer one +
/// added * the shorter one). Perfect overlap is {0, 1}. docs/tune.md, "The model".
struct ReadFit {
  double added = 0, factor = 1;
};

/// A disk, how many processors the threads of a store get, and how well reading uses both.
struct Machine {
  Disk disk;
  double processors = 1;  ///< measured, so not always a whole number
  ReadFit reading = {};
};

/// What an attribute takes, all of its levels together.
struct Work {
  double stored_bytes = 0;
  double encode_seconds = 0, decode_seconds = 0;  ///< processor time
  double block_stored_bytes = 0;                  ///< one block of the finest level
  double block_decode_seconds = 0;
  bool is_fixed = false;   ///< cannot be changed in place
  double read_factor = 1;  ///< by which a probe on the measured disk differed from the model
};

/// Seconds; nothing if the records cannot be changed in place.
struct Predicted {
  double read = 0, write = 0, patch = 0;
  std::optional<double> update;
};

Predicted predict(const std::vector<Work>& attributes, const Machine& machine);
/// The seconds of a full read of each attribute, one after another, without Work::read_factor.
std::vector<double> modelled_reads(const std::vector<Work>& attributes, const Machine& machine);

}  // namespace plait::tune
