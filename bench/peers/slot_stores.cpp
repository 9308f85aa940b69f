// What one would take instead of plait to keep a refined mesh: the same slots, and the same work,
// in a plain file, LMDB, RocksDB, SQLite and HDF5.
//
//   plait_bench_slot_stores [--level 5] [--refinements 6] [--backend pread,uring,mmap]
//                           [--reads 2000] [--queries 300] [--runs 5] [--only NAME]
//                           [--directory .]
//
// Positions and normals at all levels. Each engine loads them, durably; reads the slots of random
// faces by one thread, warm with a cache that holds everything, and cold with 64 MiB of its own
// cache and nothing in the system's; and changes the edges of a random face at all levels, durably
// (--queries times, with 64 MiB). The plain file is the floor; neither it nor HDF5 is whole after a
// crash. A turn runs all engines, and ratios are computed within a turn.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "instrument/page_cache.h"
#include "instrument/random_faces.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "peers/slot_store.h"
#include "plait/reader.h"

namespace {

using namespace plait;
using namespace plait::bench;

constexpr std::uint64_t kLargeCache = std::uint64_t{2} << 30, kSmallCache = std::uint64_t{64} << 20;

std::vector<SlotEngine> engines(const Settings& settings) {
  std::vector<SlotEngine> all = {plain_slots()};
  for (const std::string& backend : settings.backends) all.push_back(plait_slots(backend));
#ifdef PLAIT_BENCH_LMDB
  all.push_back(lmdb_slots());
#endif
#ifdef PLAIT_BENCH_ROCKSDB
  all.push_back(rocksdb_slots());
#endif
#ifdef PLAIT_BENCH_SQLITE
  all.push_back(sqlite_slots());
#endif
#ifdef PLAIT_BENCH_HDF5
  all.push_back(hdf5_slots());
#endif
  std::erase_if(all, [&](const SlotEngine& engine) {
    return &engine != all.data() && engine.name.find(settings.only) == std::string::npos;
  });
  return all;
}

/// The slots of a turn. All numbers of a slot are the same: which edge, level and version.
struct Work {
  SlotPlace place;
  std::vector<FaceId> reads, changes;
  std::vector<std::byte> into;

  std::vector<SlotKey> keys_of(FaceId face) const {
    std::vector<SlotKey> keys;
    for (std::uint32_t attribute = 0; attribute < place.sizes.attributes; ++attribute)
      for (std::uint32_t level = 1; level <= place.sizes.levels; ++level)
        for (const EdgeId edge : place.base.mesh.face_edges()[face])
          keys.push_back({attribute, level, edge});
    return keys;
  }
  static float number_of(const SlotKey& key, bool changed) {
    return static_cast<float>(32 * key.edge + key.level + (changed ? 16 : 0));
  }
  static FillSlot fill(bool changed) {
    return [changed](const SlotKey& key, std::span<std::byte> slot) {
      const float number = number_of(key, changed);
      for (std::size_t at = 0; at < slot.size(); at += sizeof number)
        std::memcpy(slot.data() + at, &number, sizeof number);
    };
  }
  /// Base records are zeros.
  void check_read(const SlotEngine& engine, SlotStore& store, FaceId face, bool changed) {
    std::ranges::fill(into, std::byte{0});
    const std::vector<SlotKey> keys = keys_of(face);
    store.read(face, keys, into);
    std::set<float> found, expected = {0};
    for (std::size_t at = 0; at < into.size(); at += sizeof(float)) {
      float number = 0;
      std::memcpy(&number, &into[at], sizeof number);
      found.insert(number);
    }
    for (const SlotKey& key : keys) expected.insert(number_of(key, changed));
    found.insert(0);
    if (found != expected)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("{}: face {} has other records than it got", engine.name, face));
  }
  double read_rate(SlotStore& store) {
    std::vector<std::vector<SlotKey>> keys;
    for (const FaceId face : reads) keys.push_back(keys_of(face));
    return static_cast<double>(reads.size()) / seconds([&] {
             for (std::size_t at = 0; at < reads.size(); ++at)
               store.read(reads[at], keys[at], into);
           });
  }
};

struct Figures {
  double load = 0, warm = 0, cold = 0, commits = 0, mebibytes = 0;
};

Figures measure(const SlotEngine& engine, Work& work) {
  Figures figures;
  SlotPlace& place = work.place;
  std::filesystem::remove_all(place.directory);
  std::filesystem::create_directories(place.directory);
  place.cache_bytes = kLargeCache;
  figures.load = seconds([&] { engine.open(place)->load(Work::fill(false)); });
  {
    const std::unique_ptr<SlotStore> store = engine.open(place);
    for (FaceId face = 0; face < place.base.mesh.face_count(); ++face)
      store->read(face, work.keys_of(face), work.into);
    figures.warm = work.read_rate(*store);
    work.check_read(engine, *store, work.reads.front(), false);
  }
  place.cache_bytes = kSmallCache;
  if (!instrument::is_cold(instrument::make_cold(instrument::files_under(place.directory))))
    say_progress(fmt::format("{}: its files stay in memory", engine.name));
  {
    const std::unique_ptr<SlotStore> store = engine.open(place);
    work.check_read(engine, *store, work.reads.back(), false);  // opens all that it needs
    figures.cold = work.read_rate(*store);
  }
  {
    const std::unique_ptr<SlotStore> store = engine.open(place);
    const FillSlot fill = Work::fill(true);
    store->change(work.keys_of(work.changes.front()), fill);
    figures.commits = static_cast<double>(work.changes.size()) / seconds([&] {
                        for (const FaceId face : work.changes)
                          store->change(work.keys_of(face), fill);
                      });
    work.check_read(engine, *store, work.changes.back(), true);
  }
  for (const std::filesystem::path& file : instrument::files_under(place.directory))
    figures.mebibytes += static_cast<double>(std::filesystem::file_size(file)) / (1u << 20);
  return figures;
}

void run(const Settings& settings) {
  const LaidOutMesh base = mesh_or_octahedron({}, settings.refinements, LayoutKind::kHilbert);
  const SlotSizes sizes{2, static_cast<std::uint32_t>(settings.level),
                        static_cast<std::uint32_t>(base.mesh.edge_count())};
  Measurements table("engine", {{"load, s", 2, true},
                                {"warm patches, /s", 0, true},
                                {"cold patches, /s", 0, true},
                                {"commits, /s", 0, true},
                                {"MiB in files", 0},
                                {"load / plain", 2},
                                {"warm / plain", 2},
                                {"cold / plain", 2},
                                {"commits / plain", 2}});
  for (int turn = 0; turn < settings.runs; ++turn) {
    const auto seed = static_cast<unsigned>(2 * turn);
    const std::size_t faces = base.mesh.face_count();
    Work work{
        {base, sizes, std::filesystem::path(settings.directory) / "slots"},
        instrument::draw_faces(false, faces, static_cast<std::size_t>(settings.reads), seed),
        instrument::draw_faces(false, faces, static_cast<std::size_t>(settings.queries), seed + 1),
        {}};
    std::size_t bytes = 0;
    for (const SlotKey& key : work.keys_of(0)) bytes += SlotSizes::bytes(key.level);
    work.into.resize(bytes);
    Figures floor;
    for (const SlotEngine& engine : engines(settings)) {
      say_progress(fmt::format("run {} of {}: {}", turn + 1, settings.runs, engine.name));
      const Figures now = measure(engine, work);
      if (floor.load == 0) floor = now;
      table.add({engine.name},
                {now.load, now.warm, now.cold, now.commits, now.mebibytes, now.load / floor.load,
                 now.warm / floor.warm, now.cold / floor.cold, now.commits / floor.commits});
    }
    std::filesystem::remove_all(work.place.directory);
  }
  table.print(
      fmt::format("{} faces at level {}, positions and normals, {:.0f} MiB, {} reads, {} "
                  "commits, {} runs",
                  base.mesh.face_count(), settings.level,
                  static_cast<double>(sizes.offset({2, 1, 0})) / (1u << 20), settings.reads,
                  settings.queries, settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_slot_stores", "Slots in other engines",
                 {.backends = {"pread", "uring", "mmap"},
                  .refinements = 6,
                  .reads = 2000,
                  .queries = 300},
                 {"--refinements", "--level", "--backend", "--reads", "--queries", "--runs",
                  "--only", "--directory"})
      .run(count, words, run);
}
