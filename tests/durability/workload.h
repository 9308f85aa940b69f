// tests/durability/workload.h: everything that a store can do between two commits, as one run whose
// every committed version is known beforehand by its digest.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plait/digest.h"
#include "plait/store.h"

namespace plait::test {

/// Is told how far a run is: version numbers are sequence numbers, 0 before the first commit.
class CommitObserver {
 public:
  virtual void committing(std::uint64_t version) = 0;
  virtual void committed(std::uint64_t version) = 0;

 protected:
  ~CommitObserver() = default;
};

/// A new store of the run's base mesh.
Store create_store(const std::filesystem::path& store, const std::string& backend,
                   Durability durability = Durability::kCommit);

/// Makes the store and takes it through levels appended, attributes added and replaced, blocks
/// overwritten in place (all of a level, some of them, one twice), a reopening in between, and at
/// last changes that are written and never committed. Frames are so few that blocks are evicted.
void run_workload(const std::filesystem::path& store, const std::string& backend,
                  CommitObserver& observer);

/// Adds one to every byte of these blocks of a level in place: block 0, `step`, 2 `step`, ...
void change_blocks(Store& store, AttributeId attribute, int level, std::uint64_t step);

/// [version]: the digest of each version of a run that nothing disturbs, at `store`, which is left
/// there. [0] stands for no store.
std::vector<Digest> digests_of_undisturbed_run(const std::filesystem::path& store,
                                               const std::string& backend);

/// The version among `versions` that the store holds when it is opened and read whole, all of it
/// verified, once for reading and once for writing; 0 if there is none to open. Fails the test if
/// the content is none of theirs.
std::uint64_t version_found(const std::filesystem::path& store,
                            const std::vector<Digest>& versions);

}  // namespace plait::test
