// Faces in a box and along a ray, against a brute force over all vertices of all patches; and the
// file of bounds: when it is used, when it is stale, and what happens to a damaged one.
#include "plait/bounds.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <random>
#include <thread>

#include "engine/store/sample_store.h"
#include "execution/reader/bounds_tree.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

constexpr int kBoundsLevels = 3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Point = Vector3<double>;

/// Writes positions near the base vertices and the middles of edges, so that patches are compact
/// and overlap. `scatter` is added to all of them.
template <class Real>
void write_positions(Store& store, AttributeId id, unsigned seed, double scatter) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> by(-scatter, scatter);
  const auto near = [&](Point p) {
    return Vector3<Real>{static_cast<Real>(p.x + by(random)), static_cast<Real>(p.y + by(random)),
                         static_cast<Real>(p.z + by(random))};
  };
  const BaseMesh& base = store.base();
  for (VertexId v = 0; v < base.vertex_count(); ++v)
    store.base_records<Vector3<Real>>(id)[v] = near(base.positions()[v]);
  for (int level = store.base_level() + 1; level <= store.base_level() + kBoundsLevels; ++level) {
    if (store.attributes()[id].finest_level < level) store.add_level(id);
    const LevelGeometry& geometry = StoreAccess::level_file(store, id, level).geometry;
    std::vector<Vector3<Real>> records;
    for (EdgeId edge = 0; edge < base.edge_count(); ++edge) {
      const Point a = base.positions()[base.edges()[edge].start];
      const Point b = base.positions()[base.edges()[edge].end];
      const std::uint64_t count = geometry.slot(edge).bytes / sizeof(Vector3<Real>);
      for (std::uint64_t i = 0; i < count; ++i) records.push_back(near(0.5 * (a + b)));
    }
    write_level(store, id, level, std::as_bytes(std::span(records)));
  }
}

/// A committed store.
struct Place {
  explicit Place(const std::string& backend = "pread", IndexedMesh mesh = torus_grid(8, 9),
                 int base_level = 0, bool wide = false)
      : is_wide(wide) {
    StoreOptions options = sample_options(backend);
    Store store = Store::create(path, BaseMesh::build(std::move(mesh)), options, default_backends(),
                                {.base_level = base_level});
    store.add_attribute(wide ? schema_of<Vector3<double>>("position")
                             : schema_of<Vector3<float>>("position"));
    write(store, 1);
    store.commit();
  }
  void write(Store& store, unsigned seed) const {
    if (is_wide)
      write_positions<double>(store, 0, seed, 0.25);
    else
      write_positions<float>(store, 0, seed, 0.25);
  }
  Store open(bool writable = false) const {
    return Store::open(path, {.writable = writable, .budget_bytes = 4 << 20}, default_backends());
  }
  fs::path file() const { return path / "attribute0.bounds"; }

  bool is_wide;
  TemporaryDirectory directory{Medium::kMemory};
  fs::path path = directory.path() / "s.plait";
};

/// For each face, smallest and largest coordinates of its vertices, read one by one.
std::vector<Box> brute_force(const Reader& reader, const Store& store, bool wide) {
  std::vector<Box> boxes;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const PatchView patch = reader.read_patch(face, store.finest_level());
    Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (std::int64_t j = 0; j <= patch.size(); ++j)
      for (std::int64_t i = 0; i + j <= patch.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
          const double at =
              wide ? patch.attribute<Vector3<double>>("position").at(i, j)[axis]
                   : double{patch.attribute<Vector3<float>>("position").at(i, j)[axis]};
          if (std::isnan(at)) continue;
          if (at < box.low[axis]) box.low[axis] = at;
          if (at > box.high[axis]) box.high[axis] = at;
        }
    if (wide)
      for (int axis = 0; axis < 3; ++axis) {  // outwards to float32
        auto low = static_cast<float>(box.low[axis]), high = static_cast<float>(box.high[axis]);
        while (double{low} > box.low[axis]) low = std::nextafter(low, -HUGE_VALF);
        while (double{high} < box.high[axis]) high = std::nextafter(high, HUGE_VALF);
        box.low[axis] = low;
        box.high[axis] = high;
      }
    boxes.push_back(box);
  }
  return boxes;
}

bool overlap(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::max(a.low[axis], b.low[axis]) > std::min(a.high[axis], b.high[axis])) return false;
  return true;
}

/// The way in along the ray, or nothing, in extended precision.
std::optional<long double> enters(const Box& box, Point from, Point along) {
  long double near = 0, far = std::numeric_limits<long double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const long double low = box.low[axis], high = box.high[axis], o = from[axis], d = along[axis];
    if (d == 0) {
      if (o < low || o > high) return std::nullopt;
      continue;
    }
    near = std::max(near, std::min((low - o) / d, (high - o) / d));
    far = std::min(far, std::max((low - o) / d, (high - o) / d));
  }
  if (near > far) return std::nullopt;
  return near;
}

Point random_point(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> in(-size, size);
  return {in(random), in(random), in(random)};
}

void check_boxes(const Reader& reader, const std::vector<Box>& boxes) {
  std::mt19937_64 random(3);
  std::uint64_t all = 0, wrong = 0;
  for (int turn = 0; turn < 200; ++turn) {
    const Point a = random_point(random, 6), size = random_point(random, turn % 2 ? 0.5 : 4);
    Box box{a, {a.x + std::abs(size.x), a.y + std::abs(size.y), a.z + std::abs(size.z)}};
    if (turn % 5 == 0) box.low.x = -kInfinity;
    if (turn % 7 == 0) box = boxes[static_cast<std::size_t>(turn) % boxes.size()];
    if (turn % 11 == 0) box.low = box.high = boxes[5].high;  // touches a corner
    std::vector<FaceId> expected;
    for (FaceId face = 0; face < boxes.size(); ++face)
      if (overlap(boxes[face], box)) expected.push_back(face);
    wrong += reader.faces_in_box(box) != expected;
    all += expected.size();
  }
  CHECK(wrong == 0);
  CHECK(all > 100);
}

void check_rays(const Reader& reader, const std::vector<Box>& boxes) {
  std::mt19937_64 random(4);
  std::uint64_t all = 0, missed = 0, extra = 0, unordered = 0;
  for (int turn = 0; turn < 200; ++turn) {
    Point from = random_point(random, 8), along = random_point(random, 1);
    const Box& some = boxes[static_cast<std::size_t>(turn) % boxes.size()];
    if (turn % 2 == 0) along = 0.5 * (some.low + some.high) - from;
    if (turn % 5 == 0) along = {0, turn % 10 == 0 ? 1.0 : -1.0, 0};
    if (turn % 10 == 0) from = {some.low.x, -10, some.high.z};  // along an edge of a box
    if (turn % 7 == 0) along = 1e-300 * along;
    if (turn % 11 == 0) from = some.high;
    const std::vector<FaceOnRay> found = reader.faces_along_ray(from, along);
    std::vector<bool> is_found(boxes.size());
    for (std::size_t at = 0; at < found.size(); ++at) {
      is_found[found[at].face] = true;
      if (at > 0)
        unordered += std::pair(found[at].distance, found[at].face) <=
                     std::pair(found[at - 1].distance, found[at - 1].face);
      Box wider = boxes[found[at].face];
      for (int axis = 0; axis < 3; ++axis) {
        wider.low[axis] -= 1e-9;
        wider.high[axis] += 1e-9;
      }
      extra += !enters(wider, from, along);
      const auto distance = enters(boxes[found[at].face], from, along);
      if (distance)
        extra += std::abs(found[at].distance - *distance) > 1e-12L * (1e-300L + *distance);
    }
    for (FaceId face = 0; face < boxes.size(); ++face)
      missed += enters(boxes[face], from, along).has_value() && !is_found[face];
    all += found.size();
  }
  CHECK(missed == 0);
  CHECK(extra == 0);
  CHECK(unordered == 0);
  CHECK(all > 100);
}

std::vector<FaceId> all_of(const Store& store) {
  return Reader(store).faces_in_box(
      {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}});
}

/// Where patches are is taken from the file, if no block is read.
bool reads_no_block(const Store& store) {
  const Reader reader(store);
  reader.faces_in_box({{0, 0, 0}, {1, 1, 1}});
  return reader.statistics().blocks_read == 0;
}

}  // namespace

TEST_CASE("ReaderFacesInBoxAndAlongRay_AreThoseOfABruteForce") {
  const auto backend = GENERATE(as<std::string>(), "pread", "mmap", "compressed");
  const bool has_file = GENERATE(false, true);
  const Place place(backend);
  const Store store = place.open();
  if (has_file) write_bounds(store);
  CHECK(reads_no_block(store) == has_file);
  const Reader reader(store);
  const std::vector<Box> boxes = brute_force(reader, store, false);
  check_boxes(reader, boxes);
  check_rays(reader, boxes);
}

TEST_CASE("ReaderFacesInBox_BordersRebasedAndWideStores_AreThoseOfABruteForce") {
  const bool wide = GENERATE(false, true);
  const int base_level = GENERATE(0, 2);
  const Place place("pread", GENERATE(sheet(5, 4), random_sheet(5, 40), single_triangle()),
                    base_level, wide);
  const Store store = place.open();
  const Reader reader(store);
  const std::vector<Box> boxes = brute_force(reader, store, wide);
  for (FaceId face = 0; face < boxes.size(); ++face) {
    std::vector<FaceId> expected;
    for (FaceId other = 0; other < boxes.size(); ++other)
      if (overlap(boxes[face], boxes[other])) expected.push_back(other);
    CHECK(reader.faces_in_box(boxes[face]) == expected);
  }
}

TEST_CASE("ReaderFacesInBox_BoxThatTouchesAWideVertex_HasItsFace") {
  const Place place("pread", random_sheet(5, 40), 0, true);
  const Store store = place.open();
  const Reader reader(store);
  std::size_t missed = 0, count = 0;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const PatchView patch = reader.read_patch(face, store.finest_level());
    for (std::int64_t j = 0; j <= patch.size(); ++j)
      for (std::int64_t i = 0; i + j <= patch.size(); ++i, ++count) {
        const Point at = patch.attribute<Point>("position").at(i, j);
        missed += !std::ranges::binary_search(reader.faces_in_box({at, at}), face);
      }
  }
  CHECK(missed == 0);
  CHECK(count > 1000);
}

TEST_CASE("BoundsTree_RayThroughAnEdgeOfABox_IsNotLostToRounding") {
  // The ray passes exactly through the edge x = low, y = high of each box. It gets there in x and y
  // after the same way, whose two computed values differ in their last bits.
  std::mt19937_64 random(31);
  const double far = 0x1p35;
  std::size_t found = 0;
  constexpr std::size_t kBoxes = 1000;
  for (std::size_t i = 0; i < kBoxes; ++i) {
    const double low = std::ldexp(double(random() % (1 << 21) + 1), -21);
    const FaceBounds box{{static_cast<float>(low), static_cast<float>(3 * low - 1), -1},
                         {static_cast<float>(low + 1), static_cast<float>(3 * low), 1}};
    found += BoundsTree({box}).along_ray({-far, -3 * far, 0}, {1, 3, 0}).size();
  }
  CHECK(found == kBoxes);
  // A box behind the origin is not on the ray, however near it is.
  const FaceBounds behind{{-2, -1, -1}, {-std::numeric_limits<float>::denorm_min(), 1, 1}};
  CHECK(BoundsTree({behind}).along_ray({0, 0, 0}, {1, 0, 0}).empty());
}

TEST_CASE("ReaderFacesInBox_VerticesThatAreNoNumbers_DoNotCount") {
  const Place place;
  Store store = place.open(true);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (Vector3<float>& point : store.base_records<Vector3<float>>(0)) point = {nan, nan, nan};
  store.base_records<Vector3<float>>(0)[0] = {nan, 500, HUGE_VALF};
  const Reader reader(store);
  check_boxes(reader, brute_force(reader, store, false));
  const std::vector<FaceId> far = reader.faces_in_box({{-9, -9, 1e30}, {9, 501, kInfinity}});
  CHECK(far.size() == 6);  // around vertex 0
}

TEST_CASE("ReaderFacesInBox_EmptyBox_HasNone") {
  const Place place;
  const Store store = place.open();
  const Reader reader(store);
  CHECK(all_of(store).size() == store.base().face_count());
  CHECK(reader.faces_in_box({{-9, -9, 1}, {9, 9, -1}}).empty());
  CHECK(reader.faces_in_box({{100, 100, 100}, {200, 200, 200}}).empty());
}

TEST_CASE("ReaderFacesInBoxAndAlongRay_WhatMakesNoSense_IsRefusedInWords") {
  const Place place;
  const Store store = place.open();
  const Reader reader(store);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const auto& call, const std::vector<std::string>& words) {
    const Error error = error_of(call);
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, words));
  };
  refused([&] { reader.faces_in_box({{0, nan, 0}, {1, 1, 1}}); }, {"in a box", "nan"});
  refused([&] { reader.faces_along_ray({0, 0, kInfinity}, {1, 0, 0}); }, {"finite origin", "inf"});
  refused([&] { reader.faces_along_ray({0, 0, 0}, {1, nan, 0}); }, {"finite direction", "nan"});
  refused([&] { reader.faces_along_ray({0, 0, 0}, {0, -0.0, 0}); }, {"not zero"});
  CHECK(error_of([&] { reader.faces_in_box({}, "normal"); }).code() == ErrorCode::kNotFound);

  Store other =
      Store::create({}, BaseMesh::build(octahedron()), {.backend = "memory"}, default_backends());
  other.add_attribute(schema_of<float>("mass"));
  refused([&] { Reader(other).faces_in_box({}, "mass"); },
          {"'mass'", "float32 x 3", "float32 x 1"});
  CHECK(error_of([&] { write_bounds(other, "mass"); }).code() == ErrorCode::kNotSupported);
}

TEST_CASE("WriteBounds_ChangedPositions_MakeTheFileStale") {
  const auto backend = GENERATE(as<std::string>(), "pread", "mmap", "uring", "compressed");
  const Place place(backend);
  {
    Store store = place.open(true);
    write_bounds(store);
    CHECK(fs::exists(place.file()));
    place.write(store, 2);
    CHECK(names(error_of([&] { write_bounds(store); }), {"'position'", "not committed"}));
    check_boxes(Reader(store), brute_force(Reader(store), store, false));
  }
  CHECK(reads_no_block(place.open()));  // the changes were discarded
  {
    Store store = place.open(true);
    place.write(store, 2);
    store.commit();
    store.add_attribute(schema_of<float>("mass"));
    store.commit();
  }
  const Store store = place.open();
  CHECK(fs::exists(place.file()));
  CHECK_FALSE(reads_no_block(store));
  const std::vector<Box> boxes =
      brute_force(Reader(store, {.attributes = {"position"}}), store, false);
  check_boxes(Reader(store), boxes);
  write_bounds(store);
  CHECK(reads_no_block(store));
  check_boxes(Reader(store), boxes);
}

TEST_CASE("ReaderFacesInBox_OfAWriterWithRecordsThatAreOnNoDisk_FindsThem") {
  const Place place;
  write_bounds(place.open());
  Store store = place.open(true);
  const float far = 1000;
  {
    Session session = StoreAccess::open_session(store);
    const PinnedBlock pinned =
        session.pin(StoreAccess::level_file(store, 0, kBoundsLevels), 0, Access::kUpdate);
    std::memcpy(pinned.bytes().data(), &far, sizeof far);
  }
  const Box there = {{far - 1, -kInfinity, -kInfinity}, {far + 1, kInfinity, kInfinity}};
  CHECK_FALSE(Reader(store).faces_in_box(there).empty());
}

TEST_CASE("ReaderFacesInBox_BoundsRemovedAsTheyAreOpened_AreComputed") {
  const Place place;
  write_bounds(place.open());
  const Store store = place.open();
  const BeforeOperation writer(FileOperation::Kind::kOpen, "attribute0.bounds",
                               [&] { fs::remove(place.file()); });
  CHECK(all_of(store).size() == store.base().face_count());
  CHECK(writer.was_done());
}

TEST_CASE("WriteBounds_OnlyBaseVerticesChange_TheFileIsStale") {
  const Place place;
  write_bounds(place.open());
  {
    Store store = place.open(true);
    store.base_records<Vector3<float>>(0)[7].x += 100;
    store.commit();
  }
  CHECK_FALSE(reads_no_block(place.open()));
}

TEST_CASE("WriteBounds_OtherAttributeChanges_TheFileIsUsed") {
  const Place place;
  write_bounds(place.open());
  {
    Store store = place.open(true);
    store.add_attribute(schema_of<float>("mass"));
    store.commit();
  }
  CHECK(reads_no_block(place.open()));
}

TEST_CASE("WriteBounds_BeforeTheFileGetsItsName_IsOnTheDisk") {
  class Order final : public FileOperationHook {
   public:
    Order() { set_file_operation_hook(this); }
    ~Order() { set_file_operation_hook(nullptr); }
    Verdict before(const FileOperation&) noexcept override { return {}; }
    void after(const FileOperation& operation) noexcept override {
      using Kind = FileOperation::Kind;
      if (operation.path.extension() == ".new" && operation.kind == Kind::kWrite) done += "write ";
      if (operation.path.extension() == ".new" && operation.kind == Kind::kSync) done += "sync ";
      if (operation.path.extension() == ".new" && operation.kind == Kind::kRename)
        done += "rename ";
      if (operation.kind == Kind::kSyncDirectory) done += "directory ";
    }
    std::string done;
  };
  const Place place;
  const Store store = place.open();
  Order order;
  write_bounds(store);
  CHECK(order.done == "write sync rename directory ");
}

TEST_CASE("WriteBounds_WhileAWriterHasTheStore_IsBusy") {
  const Place place;
  const Store reading = place.open();
  const Store writing = place.open(true);
  CHECK(error_of([&] { write_bounds(reading); }).code() == ErrorCode::kBusy);
  CHECK_FALSE(fs::exists(place.file()));
}

TEST_CASE("WriteBounds_Proceed_CountsTheBytesOfAllLevelsAndCancels") {
  const Place place;
  const Store store = place.open();
  std::uint64_t expected = 0;
  for (int level = 1; level <= store.finest_level(); ++level)
    expected += StoreAccess::level_file(store, 0, level).geometry.total_bytes();
  std::uint64_t last = 0, wrong = 0;
  write_bounds(store, "position", [&](const Progress& now) {
    wrong += now.done <= last || now.total != expected;
    last = now.done;
    return true;
  });
  CHECK(wrong == 0);
  CHECK(last == expected);

  fs::remove(place.file());
  CHECK(error_of([&] {
          write_bounds(store, "position", [](const Progress&) { return false; });
        }).code() == ErrorCode::kCancelled);
  CHECK_FALSE(fs::exists(place.file()));
  write_bounds(store);
  CHECK(fs::exists(place.file()));
}

TEST_CASE("BoundsFile_AnyByteChanged_IsNamed") {
  const Place place("pread", octahedron());
  const Store store = place.open();
  write_bounds(store);
  const std::vector<std::byte> good = file_bytes(place.file());
  REQUIRE(good.size() == 40 + 24 * 8);
  std::uint64_t wrong = 0;
  for (std::size_t at = 0; at < good.size(); ++at) {
    overwrite_byte(place.file(), at, good[at] ^ std::byte{0x40});
    const Error error = error_of([&] { Reader(store).faces_in_box({}); });
    wrong += error.code() != ErrorCode::kCorruption ||
             std::string(error.what()).find("attribute0.bounds") == std::string::npos;
    overwrite_byte(place.file(), at, good[at]);
  }
  CHECK(wrong == 0);
  for (const std::uint64_t size : {0u, 39u, 231u, 233u}) {
    fs::resize_file(place.file(), size);
    CHECK(names(error_of([&] { Reader(store).faces_in_box({}); }), {"attribute0.bounds", "232"}));
  }
  const StoreCheck check = check_store(place.path, default_backends());
  CHECK(check.damaged.empty());
  CHECK(check.left_over.empty());
  REQUIRE(check.notes.size() == 1);
  CHECK(check.notes[0].find("'position'") != std::string::npos);
  write_bounds(store);
  CHECK(file_bytes(place.file()) == good);
  CHECK(check_store(place.path, default_backends()).notes.empty());
}

TEST_CASE("BoundsFile_LinkOrFifo_IsNotOpened") {
  const Place place;
  const fs::path victim = place.directory.path() / "victim";
  write_bounds(place.open());
  fs::rename(place.file(), victim);
  const std::vector<std::byte> before = file_bytes(victim);
  fs::create_symlink(victim, place.file());
  const Store store = place.open();
  CHECK(error_of([&] { Reader(store).faces_in_box({}); }).code() == ErrorCode::kCorruption);
  fs::create_symlink(victim, fs::path(place.file()) += ".new");
  write_bounds(store);  // replaces both links
  CHECK(file_bytes(victim) == before);
  CHECK(fs::is_regular_file(fs::symlink_status(place.file())));
  CHECK(reads_no_block(store));
}

TEST_CASE("BoundsFile_OfARemovedAttribute_IsRemovedByTheNextWriter") {
  const Place place;
  write_bounds(place.open());
  {
    Store store = place.open(true);
    const AttributeId id = store.add_attribute(schema_of<Vector3<float>>("other"));
    write_positions<float>(store, id, 9, 1);
    store.replace_attribute(0, id);
    store.commit();
  }
  CHECK_FALSE(fs::exists(place.file()));
  write_bounds(place.open());
  CHECK(fs::exists(place.path / "attribute1.bounds"));
}

TEST_CASE("ReaderFacesInBox_Threads_FindTheSame") {
  const Place place;
  const Store store = place.open();
  const Reader reader(store);
  const std::vector<FaceId> expected = Reader(store).faces_in_box({{0, 0, 0}, {2, 2, 2}});
  std::atomic<std::uint64_t> wrong = 0;
  std::vector<std::thread> threads;
  for (int number = 0; number < 4; ++number)
    threads.emplace_back([&] { wrong += reader.faces_in_box({{0, 0, 0}, {2, 2, 2}}) != expected; });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
}

}  // namespace plait::test
