// The code of docs/writing.md: compiled, run, and compared with the page. clang-format leaves the
// code alone, because the page has it with the same line breaks.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "plait/create_store.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/patch.h"
#include "plait/extend/sweep.h"
#include "plait/notes.h"
#include "plait/own_rule.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

// clang-format off
struct Material {
  float density, stiffness;
};
template <>
struct plait::RecordTraits<Material> : plait::RecordOf<float, 2> {};
struct TensionRule {
  double w = 0.08;
  template <class V> V odd(V a, V b, V c, V d) const { return (0.5 - w) * (a + b) + w * (c + d); }
  template <class V> V odd_border(V a, V b) const { return 0.5 * (a + b); }
};
// clang-format on

namespace {

const plait::StoreOptions in_memory{.backend = "memory", .durability = plait::Durability::kNone};

plait::Store octahedron_of_level_3() {
  plait::Store store = plait::Store::create({}, plait::BaseMesh::build(plait::test::octahedron()),
                                            in_memory, plait::default_backends());
  plait::add_base_positions(store);
  plait::subdivide(store, {.scheme = plait::Scheme::kMidpoint, .levels = 3});
  return store;
}

/// The largest |x| + |y| + |z|, which is 1 everywhere on the octahedron.
float farthest(plait::Store& store) {
  std::atomic<float> most = 0;
  plait::visit_vertices(
      store, {}, std::tuple{plait::reads<plait::Vector3<float>>("position")},
      [&](const plait::VertexRun&, std::span<const plait::Vector3<float>> position) {
        for (const auto& p : position)
          most = std::max(most.load(), std::abs(p.x) + std::abs(p.y) + std::abs(p.z));
      });
  return most;
}

/// Lines without their indentation.
std::string unindented(const std::string& text) {
  return std::regex_replace(text, std::regex("\n[ ]+"), "\n");
}

std::string file_text(const std::string& name) {
  std::ifstream file(PLAIT_SOURCE "/" + name);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  REQUIRE(!text.empty());
  return text;
}

}  // namespace

// clang-format off
TEST_CASE("WritingPage_Visits_ReachEveryVertex") {
  plait::Store store = octahedron_of_level_3();
  using Point = plait::Vector3<float>;
  plait::visit_vertices(
      store, {.name = "scale"}, std::tuple{plait::updates<Point>("position")},
      [](const plait::VertexRun& run, std::span<Point> position) {
        for (std::size_t i = 0; i < run.count; ++i) position[i] = 2.0f * position[i];
      });
  CHECK(farthest(store) == 2);
  plait::visit_vertices(store, {.name = "relief"}, std::tuple{plait::updates<Point>("position")},
                        [](const plait::VertexRun& run, std::span<Point> position) {
                          for (std::size_t i = 0; i < run.count; ++i) {
                            const plait::PatchPoint at = run.point(i);
                            const float u = float(at.i) / float(at.size), v = float(at.j) / float(at.size);
                            position[i].z += 0.01f * std::sin(9.0f * u) * std::sin(9.0f * v);
                          }
                        });
  std::vector<float> highest(2, -INFINITY);
  plait::visit_vertices(store, {.threads = 2}, std::tuple{plait::reads<Point>("position")},
                        [&](const plait::VertexRun& run, std::span<const Point> position) {
                          float& mine = highest[std::size_t(run.worker)];
                          for (const Point& at : position) mine = std::max(mine, at.z);
                        });
  CHECK(std::ranges::max(highest) == Approx(2).margin(0.02));
  store.notes().add_face_attribute({"material", plait::ComponentType::kUint16, 1});
  for (std::uint16_t& material : store.notes().face_records<std::uint16_t>("material")) material = 7;
  store.notes().set_text("unit", "mm");
  store.add_attribute(plait::schema_of<Point>("smooth"), store.finest_level());
  plait::visit_vertices(
      store, {.name = "smooth", .threads = 2},
      std::tuple{plait::rings_of<Point>("position"), plait::overwrites<Point>("smooth")},
      [](const plait::VertexRun& run, const plait::VertexRings<Point>& position,
         std::span<Point> smooth) {
        for (std::size_t i = 0; i < run.count; ++i) {
          Point sum{};
          for (int k = 0; k < position.valence(); ++k) sum = sum + position.neighbour(i, k);
          smooth[i] = 0.5f * position.vertex(i) + 0.5f / float(position.valence()) * sum;
        }
      });
  store.replace_attribute(store.attribute("position"), store.attribute("smooth"));
  CHECK(store.attributes().size() == 1);
  CHECK(store.base_records<Point>(store.attribute("position"))[0].x < 2);
  const plait::AttributeId age = store.add_attribute(plait::schema_of<float>("age"), 3);
  CHECK(store.attributes()[age].finest_level == 3);
  plait::SweepPass pass;
  pass.name = "clear level 2";
  pass.accesses = {{age, 2, 2, plait::Access::kOverwrite}};
  pass.kernel = [](const plait::SweepView& view, plait::EdgeId edge, int) {
    std::ranges::fill(view.records<float>(0, 2, edge), 0.0f);
  };
  plait::sweep(store, pass, {.threads = 2});
}

TEST_CASE("WritingPage_OwnRecords_AreAnAttribute") {
  plait::Store store = octahedron_of_level_3();
  store.add_attribute(plait::schema_of<Material>("material"), 3);
  plait::visit_vertices(store, {}, std::tuple{plait::overwrites<Material>("material")},
                        [](const plait::VertexRun&, std::span<Material> material) {
                          std::ranges::fill(material, Material{1, 2});
                        });
  CHECK(plait::Reader(store).read_patch(0, 3).attribute<Material>("material").at(1, 2).stiffness ==
        2);
}

TEST_CASE("WritingPage_Patches_ComeFromArrays") {
  plait::Store store = octahedron_of_level_3();
  const auto heights_of = [](plait::FaceId, int level) {
    return std::vector<float>(plait::patch_vertex_count(1 << level), 4.5f);
  };
  store.add_attribute(plait::schema_of<float>("height"), 3);
  plait::PatchWriter writer(store, {.attributes = {"height"}, .compare = true});
  for (plait::FaceId face = 0; face < store.base().face_count(); ++face)
    writer.write_patch<float>("height", face, 3, heights_of(face, 3));
  writer.finish();
  CHECK(plait::Reader(store).read_patch(5, 3).attribute<float>("height").at(2, 4) == 4.5f);
}

TEST_CASE("WritingPage_OwnLoops_ReachEveryVertexOnce") {
  using Point = plait::Vector3<float>;
  plait::Store store = octahedron_of_level_3();
  const plait::AttributeId position = store.attribute("position");
  plait::StorePatches<Point> mesh(store, position, store.options().budget_bytes / 2);
  mesh.activate(3, 1, 3);  // levels up to 3 to read, levels 1 to 3 to write
  for (plait::FaceId face = 0; face < mesh.topology().faces.size(); ++face) {
    const auto patch = mesh.patch(face);
    const std::int64_t n = patch.size(3);
    for (std::int64_t j = 0; j <= n; ++j)
      for (std::int64_t i = 0; i + j <= n; ++i) {
        const int side = i + j == n ? 0 : i == 0 ? 1 : j == 0 ? 2 : -1;  // -1: inside the patch
        if (plait::is_corner(3, i, j) || (side >= 0 && !patch.owns(side))) continue;
        patch.at(3, i, j) = 0.5f * patch.at(3, i, j);
      }
  }
  for (Point& point : mesh.base_records()) point = 0.5f * point;  // the corners, once each
  CHECK(farthest(store) == 0.5f);
  int edges_seen = 0;
  const plait::Topology base = store.base().topology();
  std::vector<int> valences;
  for (plait::VertexId vertex = 0; vertex < store.base().vertex_count(); ++vertex)
    valences.push_back(plait::for_each_spoke(base, vertex, [&](plait::EdgeId edge) {
      edges_seen += base.edges[edge].start == vertex || base.edges[edge].end == vertex;
    }));
  CHECK(valences == std::vector<int>(6, 4));
  CHECK(edges_seen == 24);
}

TEST_CASE("WritingPage_OwnRule_HasOneDigest") {
  const plait::BaseMesh mesh = plait::BaseMesh::build(plait::test::octahedron());
  const plait::OneRingScheme scheme = plait::own_scheme("tension", TensionRule{});
  std::set<std::string> digests;
  for (const auto executor : {plait::ExecutorKind::kFused, plait::ExecutorKind::kSweep,
                              plait::ExecutorKind::kTransparent}) {
    plait::Store refined = plait::Store::create({}, mesh, in_memory, plait::default_backends());
    plait::add_base_positions(refined);
    plait::subdivide(refined, {.scheme = scheme, .executor = executor, .levels = 3});
    digests.insert(plait::digest(refined).to_string());
  }
  CHECK(digests.size() == 1);
}

TEST_CASE("WritingPage_Progress_CanCancelAndCommit") {
  plait::Store store = octahedron_of_level_3();
  store.add_attribute(plait::schema_of<float>("age"), 3);
  int percent = 0;
  bool stop_asked = false;
  plait::VisitOptions options;
  options.progress = [&](const plait::Progress& now) {
    percent = int(100 * now.done / now.total);
    return !stop_asked;
  };
  const auto visit = [&] {
    plait::visit_vertices(store, options, std::tuple{plait::overwrites<float>("age")},
                          [](const plait::VertexRun&, std::span<float>) {});
  };
  visit();
  CHECK(percent == 100);
  stop_asked = true;
  CHECK_THROWS_AS(visit(), plait::Error);
  CHECK_THROWS_AS(store.commit(), plait::Error);
  const plait::PagingStatistics before = store.info().paging;
  plait::visit_vertices(store, {}, std::tuple{plait::overwrites<float>("age")},
                        [](const plait::VertexRun&, std::span<float> ages) {
                          std::ranges::fill(ages, 1.0f);
                        });
  store.commit();
  const std::uint64_t written = store.info().paging.bytes_written - before.bytes_written;
  static_cast<void>(written);
}

TEST_CASE("WritingPage_ReaderBesideAWriter_KeepsItsVersion") {
  using Point = plait::Vector3<float>;
  const plait::test::TemporaryDirectory directory(plait::test::Medium::kMemory);
  const std::filesystem::path path = directory.path() / "s.plait";
  {
    plait::Store store =
        plait::create_store(path, plait::BaseMesh::build(plait::test::octahedron()));
    plait::subdivide(store, {.levels = 2});
    store.commit();
  }
  Point old_corner{};
  const plait::Store reading = plait::open_store(path);
  plait::Store writing = plait::open_store(path, {.writable = true});
  std::thread reader([&] {
    const plait::Reader patches(reading, {.attributes = {"position"}});
    old_corner = patches.read_patch(0, 2).attribute<Point>("position").at(0, 0);
  });
  plait::visit_vertices(writing, {.name = "lift"}, std::tuple{plait::updates<Point>("position")},
                        [](const plait::VertexRun&, std::span<Point> position) {
                          for (Point& at : position) at.z += 1;
                        });
  writing.commit();
  reader.join();
  const plait::Store now = plait::open_store(path);
  const plait::Reader patches(now);
  CHECK(patches.read_patch(0, 2).attribute<Point>("position").at(0, 0).z == old_corner.z + 1);
}
// clang-format on

TEST_CASE("WritingPage_EachBlockOfCode_IsInThisTest") {
  const std::string page = file_text("docs/writing.md");
  const std::string here = unindented(file_text("tests/kernels/writing_page_test.cpp"));
  const std::string start = "```cpp\n", end = "\n```";
  int blocks = 0;
  for (std::size_t at = page.find(start); at != std::string::npos; at = page.find(start, at)) {
    at += start.size();
    const std::string block = page.substr(at, page.find(end, at) - at);
    INFO(block);
    CHECK(here.find("\n" + unindented("\n" + block).substr(1) + "\n") != std::string::npos);
    ++blocks;
  }
  CHECK(blocks == 16);
}
