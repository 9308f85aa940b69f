// tools/tune/read_probes.h: stores the likely choices on the measured disk and reads them, so that
// the model of reads is measured and not assumed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "plait/store.h"
#include "tune/findings.h"

namespace plait::tune {

struct ProbeOptions {
  std::filesystem::path directory;  ///< on the measured disk; a directory in it is made and removed
  /// Of records; of larger stores, coarser levels are taken. A copy within a disk's burst would not
  /// show how the disk reads the whole store.
  std::uint64_t most_bytes = 256u << 20;
  int most_probes = 16;
  int reads = 3;  ///< of each
  /// Called often. False ends the probes; those that are complete stay.
  std::function<bool()> proceed;
};

/// Probes the blocks as they are, the fastest choice to decode, the pick, and then, as long as
/// there is time, the best choice that was not probed yet: first the pick that the corrected model
/// gives, then, if reading counts, those that may be up to 30 % better than the model says. Fills
/// findings.probes, findings.reading and findings.trials.corrections. Does nothing if the disk is
/// nearly full. Errors: those of copy_store() and read_cold(), but for kCancelled.
void probe_reads(const Store& store, const BackendRegistry& backends, const ProbeOptions& options,
                 Findings& findings);

}  // namespace plait::tune
