// tools/tune/disk_model.h: how long a store takes on a disk, computed from what it stores and from
// what its pipelines need of the processor. docs/tune.md has the formulas.
// Pinned by tests/tools/tune/disk_model_test.cpp, in closed form.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tune/figures.h"

namespace plait::tune {

/// A disk, as a store's files see it. Rates are bytes a second.
struct Disk {
  std::string name;
  double read = 0, write = 0;  ///< long runs, cold and durable
  double latency = 0;          ///< seconds until the first byte of a random read comes
  double random_read = 0;      ///< then, bytes of one random read a second
  double unwritten_bytes = 0;  ///< the system holds so much before it begins to write
  bool is_measured = false;
};
/// Disks as they are sold, and memory.
std::vector<Disk> classes_of_disks();

/// What an attribute takes, all of its levels together.
struct Work {
  double stored_bytes = 0;
  double encode_seconds = 0, decode_seconds = 0;  ///< processor time
  double block_stored_bytes = 0;                  ///< one block of the finest level
  double block_decode_seconds = 0;
  bool is_fixed = false;  ///< cannot be changed in place
};

/// Seconds; nothing if the records cannot be changed in place.
struct Predicted {
  double read = 0, write = 0, patch = 0;
  std::optional<double> update;
};

/// `processors`: how many the threads of a store get, measured, so not always a whole number.
Predicted predict(const std::vector<Work>& attributes, const Disk& disk, double processors);

}  // namespace plait::tune
