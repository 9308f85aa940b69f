// A row for each slot in RocksDB, without compression. It is loaded by one sorted file, which is
// its fastest way.
#include <rocksdb/c.h>

#include <array>
#include <string>
#include <type_traits>
#include <utility>

#include "peers/slot_store.h"

namespace plait::bench {
namespace {

void refuse_if(char* text) {
  if (!text) return;
  const std::string why = text;
  rocksdb_free(text);
  refuse("rocksdb", why);
}

/// Calls call(char** error). The functions of RocksDB set a text that the caller frees.
template <class Call>
auto checked(Call call) {
  char* text = nullptr;
  if constexpr (std::is_void_v<decltype(call(&text))>) {
    call(&text);
    refuse_if(text);
  } else {
    const auto result = call(&text);
    refuse_if(text);
    return result;
  }
}

/// Sorts as SlotKey::number() does.
std::array<char, 8> name_of(const SlotKey& key) {
  std::array<char, 8> name{};
  for (std::size_t at = 0; at < name.size(); ++at)
    name[at] = static_cast<char>(key.number() >> (56 - 8 * at));
  return name;
}

template <class Type>
using Owned = std::unique_ptr<Type, void (*)(Type*)>;

class RocksdbSlots final : public SlotStore {
 public:
  explicit RocksdbSlots(const SlotPlace& place)
      : sizes_(place.sizes), path_(place.directory / "rocksdb") {
    const Owned<rocksdb_cache_t> cache(rocksdb_cache_create_lru(place.cache_bytes),
                                       rocksdb_cache_destroy);
    rocksdb_block_based_table_options_t* const table = rocksdb_block_based_options_create();
    rocksdb_block_based_options_set_block_cache(table, cache.get());
    rocksdb_options_set_block_based_table_factory(options_.get(), table);
    rocksdb_block_based_options_destroy(table);
    rocksdb_options_set_create_if_missing(options_.get(), 1);
    rocksdb_options_set_compression(options_.get(), rocksdb_no_compression);
    rocksdb_writeoptions_set_sync(durable_.get(), 1);
    database_.reset(
        checked([&](char** error) { return rocksdb_open(options_.get(), path_.c_str(), error); }));
  }

  void load(const FillSlot& fill) override {
    const Owned<rocksdb_envoptions_t> surroundings(rocksdb_envoptions_create(),
                                                   rocksdb_envoptions_destroy);
    const Owned<rocksdb_sstfilewriter_t> writer(
        rocksdb_sstfilewriter_create(surroundings.get(), options_.get()),
        rocksdb_sstfilewriter_destroy);
    const std::string file = path_.native() + ".sst";
    checked([&](char** error) { rocksdb_sstfilewriter_open(writer.get(), file.c_str(), error); });
    std::vector<std::byte> bytes;
    sizes_.for_each([&](const SlotKey& key) {
      bytes.resize(SlotSizes::bytes(key.level));
      fill(key, bytes);
      const std::array<char, 8> name = name_of(key);
      checked([&](char** error) {
        rocksdb_sstfilewriter_put(writer.get(), name.data(), name.size(),
                                  reinterpret_cast<const char*>(bytes.data()), bytes.size(), error);
      });
    });
    checked([&](char** error) { rocksdb_sstfilewriter_finish(writer.get(), error); });
    const Owned<rocksdb_ingestexternalfileoptions_t> ingest(
        rocksdb_ingestexternalfileoptions_create(), rocksdb_ingestexternalfileoptions_destroy);
    rocksdb_ingestexternalfileoptions_set_move_files(ingest.get(), 1);
    const char* const files[] = {file.c_str()};
    checked([&](char** error) {
      rocksdb_ingest_external_file(database_.get(), files, 1, ingest.get(), error);
    });
  }
  void read(FaceId, std::span<const SlotKey> keys, std::span<std::byte> into) override {
    for (const SlotKey& key : keys) {
      const std::array<char, 8> name = name_of(key);
      const Owned<rocksdb_pinnableslice_t> found(checked([&](char** error) {
                                                   return rocksdb_get_pinned(
                                                       database_.get(), reading_.get(), name.data(),
                                                       name.size(), error);
                                                 }),
                                                 rocksdb_pinnableslice_destroy);
      std::size_t bytes = 0;
      const char* const from = found ? rocksdb_pinnableslice_value(found.get(), &bytes) : nullptr;
      if (!from) refuse("rocksdb", "no such row");
      std::copy_n(reinterpret_cast<const std::byte*>(from), bytes, into.begin());
      into = into.subspan(bytes);
    }
  }
  void change(std::span<const SlotKey> keys, const FillSlot& fill) override {
    const Owned<rocksdb_writebatch_t> batch(rocksdb_writebatch_create(),
                                            rocksdb_writebatch_destroy);
    std::vector<std::byte> bytes;
    for (const SlotKey& key : keys) {
      bytes.resize(SlotSizes::bytes(key.level));
      fill(key, bytes);
      const std::array<char, 8> name = name_of(key);
      rocksdb_writebatch_put(batch.get(), name.data(), name.size(),
                             reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    checked(
        [&](char** error) { rocksdb_write(database_.get(), durable_.get(), batch.get(), error); });
  }

 private:
  SlotSizes sizes_;
  std::filesystem::path path_;
  Owned<rocksdb_options_t> options_{rocksdb_options_create(), rocksdb_options_destroy};
  Owned<rocksdb_readoptions_t> reading_{rocksdb_readoptions_create(), rocksdb_readoptions_destroy};
  Owned<rocksdb_writeoptions_t> durable_{rocksdb_writeoptions_create(),
                                         rocksdb_writeoptions_destroy};
  Owned<rocksdb_t> database_{nullptr, rocksdb_close};
};

}  // namespace

SlotEngine rocksdb_slots() {
  return {"RocksDB", [](const SlotPlace& place) { return std::make_unique<RocksdbSlots>(place); }};
}

}  // namespace plait::bench
