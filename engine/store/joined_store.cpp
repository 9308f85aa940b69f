#include "store/joined_store.h"

#include <span>
#include <string>
#include <utility>

#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "format/version_file.h"
#include "plait/extend/file.h"
#include "store/lock.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void write_synced(const Directory& store, const std::string& name,
                  std::span<const std::byte> bytes) {
  File file(store, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
}

}  // namespace

void commit_joined_store(const Directory& store, const StoreUuid& uuid,
                         VersionDescription description,
                         const std::vector<std::vector<std::byte>>& base_records) {
  Manifest manifest;
  manifest.uuid = uuid;
  manifest.sequence = 1;
  StoreLock lock(store, LockFor::kCreating);
  lock.sign();
  for (std::size_t at = 0; at < description.attributes.size(); ++at) {
    AttributeRecord& attribute = description.attributes[at];
    write_synced(store, base_file_name(attribute.number, manifest.sequence), base_records[at]);
    attribute.base_checksum = checksum_of(base_records[at]);
  }
  const std::vector<std::byte> version = encode_version_file(encode_description(description), {});
  write_synced(store, version_file_name(manifest.sequence), version);
  manifest.version_bytes = version.size();
  manifest.version_checksum = checksum_of(version);
  manifest.required_features = required_features_of(description);
  manifest.optional_features = optional_features_of(description);
  store.sync();
  File file(store, kManifestName, OpenMode::kReadWrite);
  write_manifest(file, manifest);
  file.sync();
  file.close();
}

PLAIT_END_NAMESPACE
