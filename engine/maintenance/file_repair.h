// Rebuilds files whose damage keeps a store from being opened: base records, levels and block
// tables. The new content must have the checksums that manifest and block tables record.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "maintenance/block_proof.h"
#include "maintenance/made_again.h"
#include "plait/extend/check_store.h"
#include "plait/verify.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class FileRepair {
 public:
  /// The arguments outlive this object.
  FileRepair(const std::filesystem::path& store, const StoreCheck& check,
             const RepairOptions& options, MadeAgain& made, BlockProof& proof,
             UnpublishedDirectory& scratch, RepairReport& report)
      : store_(store),
        check_(check),
        options_(options),
        made_(made),
        proof_(proof),
        scratch_(scratch),
        report_(report) {}

  /// Rebuilds each damaged file of the check if that is possible, and enters the file into the
  /// report as rebuilt or lost.
  void run();
  /// With options.dry_run, a store of links to the whole files and of the rebuilt ones: what the
  /// store would be. Valid while the scratch directory is there. Errors: kNotSupported on a file
  /// system without hard links; kIo, kNoSpace.
  std::filesystem::path make_view();

 private:
  void repair_tables(const DamagedFile& file);
  void repair_level(const DamagedFile& file);
  void repair_base_records(const DamagedFile& file);
  /// Writes the level's file again from its whole blocks, and from made ones where a block is lost.
  /// Returns how many blocks are in neither.
  std::uint64_t make_image(const DamagedFile& file);
  /// Replaces the store's file: by these bytes, or by the image.
  void put_in_place(const DamagedFile& file, std::span<const std::byte> bytes);
  void put_in_place(const DamagedFile& file);
  void lose(const DamagedFile& file, const std::string& why);
  File create_image();
  Directory& view();
  /// Reads every block of the image by the store's backend. Returns the first damage that the
  /// backend finds.
  std::optional<std::string> reason_against_image(const DamagedFile& file);
  void put_level_in_place(const DamagedFile& file);
  const AttributeSchema& schema_of(const std::string& attribute) const;

  const std::filesystem::path& store_;
  const StoreCheck& check_;
  const RepairOptions& options_;
  MadeAgain& made_;
  BlockProof& proof_;
  UnpublishedDirectory& scratch_;
  RepairReport& report_;
  Directory view_;  ///< not open before the first file in it
};

PLAIT_END_NAMESPACE
