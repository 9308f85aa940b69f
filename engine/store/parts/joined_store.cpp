#include "store/parts/joined_store.h"

#include <span>
#include <string>
#include <utility>

#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "format/version_file.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Replaces a file that an earlier run left under its name.
void write_synced(const Directory& store, const std::string& name,
                  std::span<const std::byte> bytes) {
  store.remove(name);
  File file(store, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
}

}  // namespace

void commit_joined_version(const Directory& store, const StoreLock& lock, const StoreUuid& uuid,
                           std::uint64_t sequence, VersionDescription description,
                           const std::vector<std::vector<std::byte>>& base_records,
                           const std::vector<std::vector<std::byte>>& face_records) {
  lock.check_name(store);
  Manifest manifest;
  manifest.uuid = uuid;
  manifest.sequence = sequence;
  for (std::size_t at = 0; at < description.attributes.size(); ++at) {
    AttributeRecord& attribute = description.attributes[at];
    write_synced(store, base_file_name(attribute.number, sequence), base_records[at]);
    attribute.base_checksum = checksum_of(base_records[at]);
  }
  for (std::size_t at = 0; at < description.face_attributes.size(); ++at)
    write_synced(store, faces_file_name(description.face_attributes[at].number, sequence),
                 face_records[at]);
  const std::vector<std::byte> version = encode_version_file(encode_description(description), {});
  write_synced(store, version_file_name(sequence), version);
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
