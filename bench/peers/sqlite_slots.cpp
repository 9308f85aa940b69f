// A row for each slot in SQLite, which writes ahead (WAL) and syncs each transaction.
#include <sqlite3.h>

#include "peers/slot_store.h"

namespace plait::bench {
namespace {

class SqliteSlots final : public SlotStore {
 public:
  explicit SqliteSlots(const SlotPlace& place) : sizes_(place.sizes) {
    check(sqlite3_open((place.directory / "slots.sqlite").c_str(), &database_));
    run("PRAGMA page_size=4096; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
        "CREATE TABLE IF NOT EXISTS slots (key INTEGER PRIMARY KEY, records BLOB);"
        "PRAGMA cache_size=-" +
        std::to_string(place.cache_bytes >> 10));
    prepare("INSERT OR REPLACE INTO slots VALUES (?1, ?2)", put_);
    prepare("SELECT records FROM slots WHERE key = ?1", get_);
  }
  ~SqliteSlots() override {
    sqlite3_finalize(put_);
    sqlite3_finalize(get_);
    sqlite3_close(database_);
  }
  SqliteSlots(const SqliteSlots&) = delete;
  SqliteSlots& operator=(const SqliteSlots&) = delete;

  void load(const FillSlot& fill) override {
    run("BEGIN");
    sizes_.for_each([&](const SlotKey& key) { put(key, fill); });
    run("COMMIT; PRAGMA wal_checkpoint(TRUNCATE)");
  }
  void read(FaceId, std::span<const SlotKey> keys, std::span<std::byte> into) override {
    run("BEGIN");
    for (const SlotKey& key : keys) {
      check(sqlite3_bind_int64(get_, 1, static_cast<sqlite3_int64>(key.number())));
      if (sqlite3_step(get_) != SQLITE_ROW) refuse("sqlite", "no such row");
      const auto* const found = static_cast<const std::byte*>(sqlite3_column_blob(get_, 0));
      const auto bytes = static_cast<std::size_t>(sqlite3_column_bytes(get_, 0));
      std::copy_n(found, bytes, into.begin());
      into = into.subspan(bytes);
      check(sqlite3_reset(get_));
    }
    run("COMMIT");
  }
  void change(std::span<const SlotKey> keys, const FillSlot& fill) override {
    run("BEGIN");
    for (const SlotKey& key : keys) put(key, fill);
    run("COMMIT");
  }

 private:
  void check(int status) const {
    if (status != SQLITE_OK) refuse("sqlite", sqlite3_errmsg(database_));
  }
  void run(const std::string& text) const {
    check(sqlite3_exec(database_, text.c_str(), nullptr, nullptr, nullptr));
  }
  void prepare(const char* text, sqlite3_stmt*& statement) const {
    check(sqlite3_prepare_v2(database_, text, -1, &statement, nullptr));
  }
  void put(const SlotKey& key, const FillSlot& fill) {
    bytes_.resize(SlotSizes::bytes(key.level));
    fill(key, bytes_);
    check(sqlite3_bind_int64(put_, 1, static_cast<sqlite3_int64>(key.number())));
    check(sqlite3_bind_blob(put_, 2, bytes_.data(), static_cast<int>(bytes_.size()), nullptr));
    if (sqlite3_step(put_) != SQLITE_DONE) check(SQLITE_ERROR);
    check(sqlite3_reset(put_));
  }

  SlotSizes sizes_;
  sqlite3* database_ = nullptr;
  sqlite3_stmt* put_ = nullptr;
  sqlite3_stmt* get_ = nullptr;
  std::vector<std::byte> bytes_;
};

}  // namespace

SlotEngine sqlite_slots() {
  return {std::string("SQLite ") + SQLITE_VERSION,
          [](const SlotPlace& place) { return std::make_unique<SqliteSlots>(place); }};
}

}  // namespace plait::bench
