// How many durable commits of one face a second, beside SQLite and beside two syncs of the same
// bytes?
//
//   plait_bench_small_commits [--level 5] [--refinements 6] [--backend pread,uring] [--reads 500]
//                             [--runs 5] [--budget MIB] [--directory .]
//
// A commit changes the vertices on the edges of a random face, at all levels, of two attributes.
// SQLite (if it is installed) has one row for each edge, level and attribute, writes ahead (WAL)
// and syncs each transaction (synchronous=FULL). The floor writes as many bytes as plait's blocks
// have, and then a slot of a manifest, into files that have all their bytes, each with fdatasync. A
// turn runs all of them, and ratios are computed within a turn.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "instrument/statistics.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/store_access.h"

#ifdef PLAIT_BENCH_SQLITE
#include <sqlite3.h>
#endif

namespace {

using namespace plait;
using namespace plait::bench;

constexpr AttributeId kAttributes = 2;

std::array<EdgeId, 3> edges_of(const Store& store, FaceId face) {
  return store.base().face_edges()[face];
}

std::vector<FaceId> draw(std::size_t faces, int commits, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<FaceId> drawn(static_cast<std::size_t>(commits));
  for (FaceId& face : drawn) face = static_cast<FaceId>(random() % faces);
  return drawn;
}

/// Returns the times of the commits in seconds.
std::vector<double> commit_faces(Store& store, int level, const std::vector<FaceId>& faces) {
  std::vector<double> times;
  times.reserve(faces.size());
  for (const FaceId face : faces)
    times.push_back(seconds([&] {
      {
        Session session = StoreAccess::open_session(store);
        for (AttributeId id = 0; id < kAttributes; ++id)
          for (int at = 1; at <= level; ++at) {
            LevelFile& file = StoreAccess::level_file(store, id, at);
            for (const EdgeId edge : edges_of(store, face)) {
              const std::uint64_t block = file.geometry.block_of(edge);
              const auto slot = file.geometry.slot(edge);
              const PinnedBlock pinned = session.pin(file, block, Access::kUpdate);
              for (std::byte& byte : pinned.bytes().subspan(
                       slot.offset - file.geometry.block_offset(block), slot.bytes))
                byte ^= std::byte{1};
            }
          }
      }
      store.commit();
    }));
  return times;
}

/// The bytes of the blocks that change.
std::uint64_t bytes_of(const Store& store, int level, FaceId face) {
  std::uint64_t bytes = 0;
  for (AttributeId id = 0; id < kAttributes; ++id)
    for (int at = 1; at <= level; ++at) {
      const LevelGeometry& geometry = StoreAccess::level_file(store, id, at).geometry;
      std::set<std::uint64_t> blocks;
      for (const EdgeId edge : edges_of(store, face)) blocks.insert(geometry.block_of(edge));
      for (const std::uint64_t block : blocks) bytes += geometry.block_bytes(block);
    }
  return bytes;
}

double floor_seconds(const std::filesystem::path& directory, const Store& store, int level,
                     const std::vector<FaceId>& faces) {
  std::uint64_t all = 0, most = 0;
  for (const FaceId face : faces) {
    const std::uint64_t bytes = bytes_of(store, level, face);
    all += bytes;
    most = std::max(most, bytes);
  }
  const std::filesystem::path log_path = directory / "floor.log", slot_path = directory / "floor";
  const std::vector<std::byte> from(std::max<std::uint64_t>(most, 4096), std::byte{1});
  std::filesystem::remove(log_path);
  std::filesystem::remove(slot_path);
  File log(log_path, OpenMode::kCreate), slot(slot_path, OpenMode::kCreate);
  for (std::uint64_t at = 0; at < all; at += from.size()) log.write_at(at, from);
  slot.write_at(0, std::span(from).first(4096));
  log.sync();
  slot.sync();
  std::uint64_t at = 0;
  return seconds([&] {
    for (const FaceId face : faces) {
      const std::uint64_t bytes = bytes_of(store, level, face);
      log.write_at(at, std::span(from).first(bytes));
      log.sync();
      slot.write_at(0, std::span(from).first(4096));
      slot.sync();
      at += bytes;
    }
  });
}

#ifdef PLAIT_BENCH_SQLITE
class Database {
 public:
  explicit Database(const std::filesystem::path& path) {
    for (const char* const suffix : {"", "-wal", "-shm"})
      std::filesystem::remove(path.native() + suffix);
    check(sqlite3_open(path.c_str(), &database_));
    run("PRAGMA page_size=4096; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
        "CREATE TABLE slots (key INTEGER PRIMARY KEY, records BLOB);");
    check(sqlite3_prepare_v2(database_, "INSERT OR REPLACE INTO slots VALUES (?1, ?2)", -1, &put_,
                             nullptr));
  }
  ~Database() {
    sqlite3_finalize(put_);
    sqlite3_close(database_);
  }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  void run(const char* text) { check(sqlite3_exec(database_, text, nullptr, nullptr, nullptr)); }
  void put(std::int64_t key, std::span<const std::byte> records) {
    check(sqlite3_bind_int64(put_, 1, key));
    check(sqlite3_bind_blob(put_, 2, records.data(), static_cast<int>(records.size()),
                            SQLITE_STATIC));
    if (sqlite3_step(put_) != SQLITE_DONE) check(SQLITE_ERROR);
    check(sqlite3_reset(put_));
  }

 private:
  void check(int status) const {
    if (status != SQLITE_OK)
      throw Error(ErrorCode::kIo, fmt::format("sqlite: {}", sqlite3_errmsg(database_)));
  }
  sqlite3* database_ = nullptr;
  sqlite3_stmt* put_ = nullptr;
};

void put_slot(Database& database, const Store& store, AttributeId id, int level, EdgeId edge,
              std::span<const std::byte> bytes) {
  const auto slot = StoreAccess::level_file(store, id, level).geometry.slot(edge);
  database.put((std::int64_t{id} * 32 + level) << 32 | std::int64_t{edge}, bytes.first(slot.bytes));
}

void fill(Database& database, const Store& store, int level) {
  const std::vector<std::byte> bytes(1 << 20);
  database.run("BEGIN");
  for (AttributeId id = 0; id < kAttributes; ++id)
    for (int at = 1; at <= level; ++at)
      for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge)
        put_slot(database, store, id, at, edge, bytes);
  database.run("COMMIT");
}

std::vector<double> commit_rows(Database& database, const Store& store, int level,
                                const std::vector<FaceId>& faces, std::byte value) {
  const std::vector<std::byte> bytes(1 << 20, value);
  std::vector<double> times;
  times.reserve(faces.size());
  for (const FaceId face : faces)
    times.push_back(seconds([&] {
      database.run("BEGIN");
      for (AttributeId id = 0; id < kAttributes; ++id)
        for (int at = 1; at <= level; ++at)
          for (const EdgeId edge : edges_of(store, face))
            put_slot(database, store, id, at, edge, bytes);
      database.run("COMMIT");
    }));
  return times;
}
#endif

double sum(const std::vector<double>& times) {
  double all = 0;
  for (const double time : times) all += time;
  return all;
}

void run(const Settings& settings) {
  const LaidOutMesh base = mesh_or_octahedron({}, settings.refinements, LayoutKind::kHilbert);
  Measurements table("what", {{"commits a second", 0, true},
                              {"p50, us", 0},
                              {"p99, us", 0},
                              {"rate / floor", 2, true},
                              {"rate / SQLite", 2, true}});
  std::vector<Store> stores;
  for (const std::string& backend : settings.backends) {
    const std::filesystem::path path = settings.store().native() + backend;
    std::filesystem::remove_all(path);
    StoreOptions options;
    options.backend = backend;
    options.budget_bytes = settings.budget_bytes();
    stores.push_back(Store::create(path, base, options, default_backends()));
    add_base_positions(stores.back());
    subdivide(stores.back(), {.levels = settings.level, .normals = true});
    stores.back().commit();
  }
#ifdef PLAIT_BENCH_SQLITE
  say_progress("SQLite: making a database");
  Database database(std::filesystem::path(settings.directory) / "small.sqlite");
  fill(database, stores.front(), settings.level);
#endif
  const auto commits = static_cast<double>(settings.reads);
  for (int turn = 0; turn < settings.runs; ++turn) {
    say_progress(fmt::format("run {} of {}", turn + 1, settings.runs));
    const std::vector<FaceId> faces =
        draw(stores.front().base().face_count(), settings.reads, static_cast<unsigned>(turn));
    const double floor = floor_seconds(settings.directory, stores.front(), settings.level, faces);
    double peer = Measurements::kNone;
    const auto add = [&](const std::string& name, const std::vector<double>& times) {
      table.add({name},
                {commits / sum(times), 1e6 * instrument::quantile(times, 0.5),
                 1e6 * instrument::quantile(times, 0.99), floor / sum(times), peer / sum(times)});
    };
#ifdef PLAIT_BENCH_SQLITE
    const std::vector<double> times = commit_rows(database, stores.front(), settings.level, faces,
                                                  static_cast<std::byte>(turn + 1));
    peer = sum(times);
    add("SQLite", times);
#endif
    for (std::size_t at = 0; at < stores.size(); ++at)
      add(settings.backends[at], commit_faces(stores[at], settings.level, faces));
    table.add({"floor"},
              {commits / floor, Measurements::kNone, Measurements::kNone, 1, peer / floor});
  }
  table.print(fmt::format("{} faces at level {}, positions and normals, {} commits, {} runs",
                          stores.front().base().face_count(), settings.level, settings.reads,
                          settings.runs));
  for (std::size_t at = 0; at < stores.size(); ++at) {
    std::uint64_t bytes = 0;
    const std::filesystem::path path = stores[at].path();
    stores[at].close();
    for (const auto& entry : std::filesystem::directory_iterator(path))
      bytes += static_cast<std::uint64_t>(entry.file_size());
    fmt::print("{}: {} MiB in files at the end\n", settings.backends[at], bytes >> 20);
  }
}

}  // namespace

int main(int count, char** words) {
  return Program(
             "plait_bench_small_commits", "Commits of one face",
             {.backends = {"pread", "uring"}, .refinements = 6, .reads = 500, .budget_mib = 256},
             {"--refinements", "--level", "--backend", "--reads", "--runs", "--budget",
              "--directory"})
      .run(count, words, run);
}
