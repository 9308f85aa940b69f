#include "store/version_writer.h"

#include <algorithm>
#include <string>

#include "format/base_mesh_file.h"
#include "format/base_records_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "format/version_file.h"
#include "io/copy_range.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Replaces a file that an earlier run left under its name.
void write_whole_file(const Directory& store, const std::string& name,
                      std::span<const std::byte> bytes, bool durable) {
  store.remove(name);
  File file(store, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  if (durable) file.sync();
  file.close();
}

/// A file of the version that has the bytes of `from`, or is this file.
StoredSize publish_file(const Directory& store, const std::string& name, const File& from,
                        bool durable) {
  if (from.path().filename() != name) {
    store.remove(name);
    File file(store, name, OpenMode::kCreate);
    copy_range(from, file, 0, from.size());
    file.close();
  }
  File file(store, name, OpenMode::kReadWrite);
  if (durable) file.sync();
  const StoredSize size{file.size(), checksum_of(file)};
  file.close();
  return size;
}

void write_slot(const Directory& store, const Manifest& manifest, bool durable) {
  File file(store, kManifestName, OpenMode::kReadWrite);
  write_manifest(file, manifest);
  if (durable) file.sync();
  file.close();
}

bool has_predicted(const BlockTable* table) {
  return std::ranges::find(table->entries(), BlockEncoding::kPredicted, &BlockEntry::encoding) !=
         table->entries().end();
}

}  // namespace

Manifest publish_version(const Directory& store, const StoreLock& lock, const StoreUuid& uuid,
                         std::uint64_t sequence, VersionContent content, bool durable) {
  lock.check_name(store);
  VersionDescription& description = content.description;
  for (std::size_t at = 0; at < description.attributes.size(); ++at) {
    AttributeRecord& attribute = description.attributes[at];
    if (const File* const file = content.base_files.empty() ? nullptr : content.base_files[at];
        file != nullptr && !content.positions) {
      const StoredSize size =
          publish_file(store, base_file_name(attribute.number, sequence), *file, durable);
      attribute.base_bytes = size.bytes;
      attribute.base_checksum = size.checksum;
      continue;
    }
    std::span<const std::byte> bytes = content.base_records[at];
    std::vector<std::byte> packed;
    if (content.positions)
      bytes = packed = encode_base_records(attribute.schema, bytes, *content.positions);
    write_whole_file(store, base_file_name(attribute.number, sequence), bytes, durable);
    attribute.base_bytes = bytes.size();
    attribute.base_checksum = checksum_of(bytes);
  }
  for (std::size_t at = 0; at < description.face_attributes.size(); ++at) {
    FaceAttributeRecord& attribute = description.face_attributes[at];
    write_whole_file(store, faces_file_name(attribute.number, sequence), content.face_records[at],
                     durable);
    attribute.checksum = checksum_of(content.face_records[at]);
  }
  const std::vector<std::byte> version =
      encode_version_file(encode_description(description), content.tables);
  write_whole_file(store, version_file_name(sequence), version, durable);
  Manifest manifest;
  manifest.uuid = uuid;
  manifest.sequence = manifest.described = sequence;
  manifest.log = content.log;
  manifest.version_bytes = version.size();
  manifest.version_checksum = checksum_of(version);
  manifest.required_features = required_features_of(description);
  if (std::ranges::any_of(content.tables, has_predicted))
    manifest.required_features |= kPredictedBlocks;
  if (manifest.log.generation != 0) manifest.required_features |= kChangeLog;
  manifest.optional_features = optional_features_of(description);
  if (durable) store.sync();
  write_slot(store, manifest, durable);
  return manifest;
}

void publish_changes(const Directory& store, const StoreLock& lock, const Manifest& version,
                     bool durable) {
  lock.check_name(store);
  write_slot(store, version, durable);
}

PLAIT_END_NAMESPACE
