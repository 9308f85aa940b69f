// tests/engine/store/sample_store.h: stores whose every byte is known beforehand.
//
// The content of a slot follows from the attribute's name, the level, the edge's endpoints and the
// place in the slot, and not from the edge's number: it is the same in every layout. The bytes of
// an attribute called "noise" do not compress; those of others do after a shuffle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "plait/error.h"
#include "plait/store.h"

namespace plait::test {

/// Blocks of 4 KiB and no waiting for the disk.
StoreOptions sample_options(const std::string& backend, std::uint64_t block_bytes = 4096);

/// float32 x 3, float64, uint8, uint32, int16 x 255, and "noise", uint8 x 5.
std::vector<AttributeSchema> sample_schemas();

/// The bytes of the slot of an edge, or, for start == end, of the record of a base vertex.
std::vector<std::byte> sample_slot(const AttributeSchema& schema, int level, VertexId start,
                                   VertexId end, std::size_t bytes);
std::vector<std::byte> sample_base(const Store& store, const AttributeSchema& schema);
/// All slots of a level one after another, as docs/format.md lays them out.
std::vector<std::byte> sample_level(const Store& store, const AttributeSchema& schema, int level);

/// Adds the attribute with `levels` levels beyond the base and writes its sample content.
AttributeId add_sample(Store& store, const AttributeSchema& schema, int levels);
void write_level(Store& store, AttributeId attribute, int level, std::span<const std::byte> bytes);
/// By way of the pager.
std::vector<std::byte> read_level(Store& store, AttributeId attribute, int level);
/// Whether base records and all levels of the attribute are the sample's.
bool holds_sample(Store& store, AttributeId attribute);

/// Commits another version of the same content. Store::commit() makes none without a change.
void commit_anew(Store& store);

/// Of the store's budget, which is larger, exactly so much is for frames from now on, whatever its
/// backend keeps for itself.
void leave_for_frames(Store& store, std::uint64_t bytes);

/// The names of the built-in backends that keep data on disk.
std::vector<std::string> durable_backends();

std::set<std::string> file_names(const std::filesystem::path& directory);
std::vector<std::byte> file_bytes(const std::filesystem::path& file);
void overwrite_byte(const std::filesystem::path& file, std::uint64_t offset, std::byte value);

/// Whether the message names all of `words`; if not, the test is told the message.
bool names(const Error& error, const std::vector<std::string>& words);

}  // namespace plait::test
