// A row for each slot in LMDB, which maps its file; its cache is the system's page cache.
#include <lmdb.h>

#include "peers/slot_store.h"

namespace plait::bench {
namespace {

constexpr std::size_t kMapBytes = std::size_t{1} << 36;

void check(int status) {
  if (status != MDB_SUCCESS) refuse("lmdb", mdb_strerror(status));
}

class Transaction {
 public:
  Transaction(MDB_env* environment, unsigned flags) {
    check(mdb_txn_begin(environment, nullptr, flags, &transaction_));
    check(mdb_dbi_open(transaction_, nullptr, MDB_INTEGERKEY | MDB_CREATE, &database_));
  }
  ~Transaction() {
    if (transaction_) mdb_txn_abort(transaction_);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void put(const SlotKey& key, const FillSlot& fill, unsigned flags) {
    std::uint64_t number = key.number();
    MDB_val name{sizeof number, &number}, value{SlotSizes::bytes(key.level), nullptr};
    check(mdb_put(transaction_, database_, &name, &value, flags | MDB_RESERVE));
    fill(key, {static_cast<std::byte*>(value.mv_data), value.mv_size});
  }
  std::span<const std::byte> get(const SlotKey& key) {
    std::uint64_t number = key.number();
    MDB_val name{sizeof number, &number}, value{};
    check(mdb_get(transaction_, database_, &name, &value));
    return {static_cast<const std::byte*>(value.mv_data), value.mv_size};
  }
  void commit() { check(mdb_txn_commit(std::exchange(transaction_, nullptr))); }

 private:
  MDB_txn* transaction_ = nullptr;
  MDB_dbi database_ = 0;
};

class LmdbSlots final : public SlotStore {
 public:
  explicit LmdbSlots(const SlotPlace& place) : sizes_(place.sizes) {
    check(mdb_env_create(&environment_));
    check(mdb_env_set_mapsize(environment_, kMapBytes));
    check(mdb_env_open(environment_, place.directory.c_str(), MDB_NORDAHEAD, 0644));
  }
  ~LmdbSlots() override { mdb_env_close(environment_); }
  LmdbSlots(const LmdbSlots&) = delete;
  LmdbSlots& operator=(const LmdbSlots&) = delete;

  void load(const FillSlot& fill) override {
    Transaction all(environment_, 0);
    sizes_.for_each([&](const SlotKey& key) { all.put(key, fill, MDB_APPEND); });
    all.commit();
  }
  void read(FaceId, std::span<const SlotKey> keys, std::span<std::byte> into) override {
    Transaction reading(environment_, MDB_RDONLY);
    for (const SlotKey& key : keys) {
      const std::span<const std::byte> found = reading.get(key);
      std::ranges::copy(found, into.begin());
      into = into.subspan(found.size());
    }
  }
  void change(std::span<const SlotKey> keys, const FillSlot& fill) override {
    Transaction changing(environment_, 0);
    for (const SlotKey& key : keys) changing.put(key, fill, 0);
    changing.commit();
  }

 private:
  SlotSizes sizes_;
  MDB_env* environment_ = nullptr;
};

}  // namespace

SlotEngine lmdb_slots() {
  return {"LMDB " + std::to_string(MDB_VERSION_MAJOR) + "." + std::to_string(MDB_VERSION_MINOR),
          [](const SlotPlace& place) { return std::make_unique<LmdbSlots>(place); }};
}

}  // namespace plait::bench
