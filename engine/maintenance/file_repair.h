// Files that keep a store from being opened: base records, levels and block tables are put back
// whole, by content that has the checksums which manifest and block tables record.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "maintenance/block_proof.h"
#include "maintenance/recomputed_store.h"
#include "plait/check_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class FileRepair {
 public:
  /// The arguments outlive this object.
  FileRepair(const std::filesystem::path& store, const StoreCheck& check,
             const RepairOptions& options, RecomputedStore& recomputed, BlockProof& proof,
             PartialDirectory& scratch, RepairReport& report)
      : store_(store),
        check_(check),
        options_(options),
        recomputed_(recomputed),
        proof_(proof),
        scratch_(scratch),
        report_(report) {}

  /// Enters every damaged file of the check into the report, rebuilt or lost.
  void run();

 private:
  void repair_tables(const DamagedFile& file);
  bool rebuild_base_records(const DamagedFile& file);
  void repair_level(const DamagedFile& file);
  /// Writes the level's file into the scratch directory, of blocks computed anew, where `made` is
  /// given, and of those that are still whole. The number of blocks for which there is neither.
  std::uint64_t make_image(const DamagedFile& file, Store* made);
  /// The content, or the image that was made.
  void put_in_place(const DamagedFile& file, std::span<const std::byte> bytes);
  void put_in_place(const DamagedFile& file);
  void lose(const DamagedFile& file, const std::string& why);
  File create_image();
  /// What the store's backend finds wrong when it reads every block of the image.
  std::optional<std::string> reason_against_image(const DamagedFile& file);
  void put_level_in_place(const DamagedFile& file);
  const AttributeSchema& schema_of(const std::string& attribute) const;

  const std::filesystem::path& store_;
  const StoreCheck& check_;
  const RepairOptions& options_;
  RecomputedStore& recomputed_;
  BlockProof& proof_;
  PartialDirectory& scratch_;
  RepairReport& report_;
};

PLAIT_END_NAMESPACE
