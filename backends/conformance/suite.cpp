#include "conformance/suite.h"

#include <exception>

namespace plait::conformance {
namespace {

bool of_all(const BackendTraits&) { return true; }
bool of_memory(const BackendTraits& traits) { return traits.in_memory; }
bool of_mapped(const BackendTraits& traits) { return traits.maps_for_reading; }
bool of_transfers(const BackendTraits& traits) { return !traits.in_memory; }
bool of_codecs(const BackendTraits& traits) { return traits.compressed; }
bool of_files(const BackendTraits& traits) { return traits.durable; }
bool of_shared_files(const BackendTraits& traits) { return traits.shares_files; }

constexpr Promise kPromises[] = {
    {"entry-agrees", "The traits and the summary of the entry are those of the backend.", of_all,
     check_entry},
    {"read-never-written", "A block that was never written reads as zeros.", of_all,
     check_never_written},
    {"read-what-was-written",
     "read() gives the bytes that write() got, for levels of any shape and blocks of any size.",
     of_all, check_shapes},
    {"write-over-old-content", "A block that is written again has the new content, and no other.",
     of_all, check_overwriting},
    {"request-in-bounds", "Blocks that the level does not have are refused (kInvalidArgument).",
     of_all, check_bounds},
    {"table-of-the-level", "A block table of another size is refused (kInvalidArgument).", of_all,
     check_table_size},
    {"advice-changes-nothing", "Advice never fails and never changes a result.", of_all,
     check_advice},
    {"threads", "Two threads may read and write different blocks at the same time.", of_all,
     check_threads},
    {"context-is-stable", "The blocks that a block needs stay the same, and come earlier.", of_all,
     check_context},
    {"address-in-memory", "The blocks of a level in memory keep their addresses.", of_memory,
     check_address_in_memory},
    {"address-mapped", "The blocks of a mapped level keep their addresses, and are verified there.",
     of_mapped, check_address_mapped},
    {"codec-gives-back", "A codec gives back every bit of each block that it encodes.", of_codecs,
     check_codec_gives_back},
    {"codec-is-repeatable", "A codec encodes equal blocks to equal bytes, whatever came before.",
     of_codecs, check_codec_is_repeatable},
    {"codec-stays-inside", "A codec accesses only the memory that it gets, whatever is stored.",
     of_codecs, check_codec_stays_inside},
    {"transfers-end-once", "Each transfer that starts ends once, with the bytes of its block.",
     of_transfers, check_transfers},
    {"transfer-of-damaged-block",
     "A block whose checksum differs fails (kCorruption), and no other block does.", of_transfers,
     check_damaged_transfer},
    {"reopened-level", "A level that is opened again has the same bytes.", of_files,
     check_reopening},
    {"open-modes", "A level is created once, and is opened only if it exists.", of_files,
     check_modes},
    {"read-only-level", "A level that was opened for reading refuses writes (kBadState).", of_files,
     check_read_only},
    {"flipped-bit", "A flipped bit of a stored block is found (kCorruption).", of_files,
     check_flipped_bit},
    {"swapped-blocks", "Two blocks that changed places are found (kCorruption).", of_files,
     check_swapped_blocks},
    {"file-cut-short", "A file that was cut short is found (kCorruption).", of_files,
     check_file_cut_short},
    {"file-cut-while-open", "A file that is cut short while it is open is an error, not a crash.",
     of_files, check_file_cut_while_open},
    {"failed-write", "A write that fails leaves the block as it was.", of_files,
     check_failed_write},
    {"bad-table-entries", "Table entries that cannot be are refused (kCorruption).", of_files,
     check_bad_entries},
    {"shared-file", "Levels that are written into one file have their bytes.", of_shared_files,
     check_shared_file},
};

}  // namespace

std::span<const Promise> promises() { return kPromises; }

CheckLog check(const Promise& promise, const Subject& subject) {
  CheckLog log;
  try {
    promise.check(subject, log);
  } catch (const CheckEnded&) {  // the log has the reason
  } catch (const std::exception& error) {
    log.expect(false, std::string("no exception leaves the check: ") + error.what());
  } catch (...) {
    log.expect(false, "no exception leaves the check: found one of an unknown type");
  }
  return log;
}

}  // namespace plait::conformance
