// Recovers a store of one level file with a rollback journal: first a journal with a right header
// and the input as its rest, then the input as the whole journal. Either recovery refuses the
// journal, or afterwards the journal is removed and the level file is as long as before.
#include <xxhash.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "durability/faults.h"
#include "oracle.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "store/file_names.h"
#include "store/rollback_journal.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

constexpr std::uint64_t kSequence = 7, kLevelBytes = 4096;

/// A directory that contains a level file.
struct Place {
  Place() { std::ofstream(path / level_file_name(0, 1, 1)) << std::string(kLevelBytes, 'x'); }
  /// The level of one block, as the newest version describes it.
  std::vector<StoredLevel> levels() const {
    std::vector<StoredLevel> result(1);
    result[0].level = 1;
    result[0].record.generation = 1;
    result[0].geometry =
        LevelGeometry(SlotShapes(kLevelBytes), BaseRelativeLevel(1), 1, kLevelBytes);
    result[0].table = BlockTable({}, 0, 1, 1);
    result[0].table.mark_written(0, 0, kLevelBytes);
    return result;
  }
  test::TemporaryDirectory directory;
  std::filesystem::path path = directory.path();
};

/// docs/format.md, "journal".
std::vector<std::byte> right_header() {
  std::vector<std::byte> bytes(48);
  std::memcpy(bytes.data(), "plaitjnl", 8);
  save(std::span(bytes), 8, std::uint32_t{1});
  save(std::span(bytes), 32, kSequence);
  save(std::span(bytes), 40, checksum_of(std::span(bytes).first(40)));
  return bytes;
}

/// Gives each whole record the right checksum.
void seal_records(std::span<std::byte> bytes, std::uint64_t seed) {
  while (bytes.size() >= 40) {
    const auto count = load<std::uint64_t>(bytes, 24);
    if (count > bytes.size() - 40) return;
    XXH3_state_t* const state = XXH3_createState();
    XXH3_64bits_reset_withSeed(state, seed);
    XXH3_64bits_update(state, bytes.data(), 32);
    XXH3_64bits_update(state, bytes.subspan(40).data(), count);
    save(bytes, 32, std::uint64_t{XXH3_64bits_digest(state)});
    XXH3_freeState(state);
    bytes = bytes.subspan(40 + count);
  }
}

void try_journal(const Place& place, std::span<const std::byte> bytes) {
  const std::filesystem::path journal = place.path / kJournalName;
  std::ofstream(journal, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  const bool taken = accepts({ErrorCode::kCorruption}, [&] {
    const Directory store(place.path);
    if (is_hot_journal(store, {}, kSequence))
      roll_back(store, {}, kSequence, place.levels());
    else
      remove_journal(store);
  });
  require(taken != std::filesystem::exists(journal));
  require(std::filesystem::file_size(place.path / level_file_name(0, 1, 1)) == kLevelBytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Place place;
  static const test::NoWaiting no_waiting;
  const auto input = std::as_bytes(std::span(data, size));
  try_journal(place, input);
  std::vector<std::byte> bytes = right_header();
  // With right checksums, whatever the records contain.
  const auto seed = load<std::uint64_t>(bytes, 40);
  bytes.insert(bytes.end(), input.begin(), input.end());
  try_journal(place, bytes);
  seal_records(std::span(bytes).subspan(48), seed);
  try_journal(place, bytes);
  return 0;
}
