// A subdivision whose base mesh is larger than its budget takes it in pieces, and gives the store
// of the whole mesh.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "laid_out_base.h"
#include "mesh/mesh_piece.h"
#include "parts/base_in_ranges.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/shuffled_mesh.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kSmallBudget = 512 << 10, kBudgetOfTwoLevels = 2 << 20;

/// Larger than the budget, with borders, seams of no kind, and a vertex of many faces (a hub of the
/// fused executor).
IndexedMesh mesh_for_pieces() {
  const std::uint32_t part = unless_sanitized(1u, 2u);
  return shuffled(side_by_side({torus_grid(180 / part, 140), sheet(50, 40), bipyramid(300),
                                random_sphere(3, 60), open_fan(30)}),
                  7);
}

SubdivisionRequest request_in_pieces(const std::filesystem::path& mesh,
                                     const std::filesystem::path& store) {
  return {.mesh = mesh,
          .store = store,
          .backend = "pread",
          .block_bytes = 4096,
          .budget_bytes = kSmallBudget,
          .durability = Durability::kNone,
          .digest = true};
}

SubdivisionResult run_request(const SubdivisionRequest& request, const JobWatch& watch = {}) {
  return SubdivisionJob(request, default_backends()).run(watch);
}

std::string digest_at(const std::filesystem::path& store) {
  return digest(Store::open(store, {}, default_backends()), {}).to_string();
}

void check_piece(const BaseMesh& whole, const MeshPiece& piece) {
  const Topology mesh = whole.topology(), found = piece.topology();
  CHECK(std::ranges::is_sorted(piece.vertices));
  REQUIRE(piece.positions.size() == piece.vertices.size());
  std::uint64_t same = 0;
  for (EdgeId edge = piece.first; edge < piece.after; ++edge) {
    const Edge& of_piece = found.edges[piece.edges_before + (edge - piece.first)];
    const Edge& of_mesh = mesh.edges[edge];
    if (piece.vertices[of_piece.start] == of_mesh.start &&
        piece.vertices[of_piece.end] == of_mesh.end && of_piece.is_border() == of_mesh.is_border())
      ++same;
  }
  CHECK(same == piece.after - piece.first);
  for (const VertexId vertex : piece.walkable) {
    const VertexId number = piece.vertices[vertex];
    FaceSide here = found.vertex_corners[vertex], there = mesh.vertex_corners[number];
    const FaceSide first = there;
    bool is_same = true;
    do {
      const auto& corners = found.faces[here.face()];
      for (std::size_t side = 0; side < 3; ++side)
        is_same = is_same && piece.vertices[corners[side]] == mesh.faces[there.face()][side];
      is_same = is_same && here.side() == there.side();
      here = found.next_corner(here);
      there = mesh.next_corner(there);
      is_same = is_same && here.exists() == there.exists();
    } while (is_same && there.exists() && there != first);
    if (!is_same) FAIL("vertex " << number << " is another one in the piece");
  }
}

}  // namespace

TEST_CASE("Pieces of a base mesh are what it has there, and each vertex is one piece's own") {
  const TemporaryDirectory files(Medium::kMemory);
  for (const NamedMesh& named : all_meshes()) {
    INFO(named.name);
    const std::filesystem::path path = files.path() / (std::string(named.name) + ".base");
    const BaseMesh whole = laid_out_at(path, named.mesh);
    const BaseMesh stored = open_base_directory(path).in_pieces(1 << 20);
    const std::uint64_t memory = stored.memory_bytes();
    for (const EdgeId length : {1u, 2u, 7u, 1000000u}) {
      std::vector<int> owners(whole.vertex_count());
      for (EdgeId first = 0; first < whole.edge_count();) {
        const EdgeId after = static_cast<EdgeId>(
            std::min<std::uint64_t>(whole.edge_count(), std::uint64_t{first} + length));
        const MeshPiece piece = take_piece(stored, first, after);
        check_piece(whole, piece);
        for (const VertexId vertex : piece.own) ++owners[piece.vertices[vertex]];
        first = after;
      }
      CHECK(std::ranges::all_of(owners, [](int count) { return count == 1; }));
      CHECK(stored.memory_bytes() == memory);  // nothing was kept
    }
  }
}

TEST_CASE("A subdivision in pieces gives the store of the whole mesh") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  laid_out_at(path, mesh_for_pieces());
  REQUIRE(BaseInRanges::whole_bytes(path) > kBudgetOfTwoLevels);
  const auto check_same = [&](const std::function<void(SubdivisionRequest&)>& change) {
    SubdivisionRequest request = request_in_pieces(path, files.path() / "pieces.plait");
    change(request);
    SubdivisionRequest whole = request;
    whole.store = files.path() / "whole.plait";
    whole.budget_bytes = 64 << 20;
    const SubdivisionResult of_pieces = run_request(request), of_whole = run_request(whole);
    CHECK(of_pieces.plan.piece_bytes == request.budget_bytes / 2);
    CHECK(of_whole.plan.piece_bytes == 0);
    CHECK(of_pieces.plan.warnings == of_whole.plan.warnings);
    CHECK(of_pieces.plan.seam_vertices == of_whole.plan.seam_vertices);
    CHECK(of_pieces.digest == of_whole.digest);
    CHECK(digest_at(request.store) == of_whole.digest);
    CHECK(of_pieces.stored_bytes == of_whole.stored_bytes);
    CHECK(Directory(request.store).names() == Directory(whole.store).names());
    CHECK(Directory(files.path()).names() ==
          std::vector<std::string>{"m.base", "pieces.plait", "whole.plait"});
  };
  SECTION("one level") {
    check_same([](SubdivisionRequest&) {});
  }
  SECTION("another backend") {
    check_same([](SubdivisionRequest& request) { request.backend = "mmap"; });
  }
  SECTION("normals and limit positions") {
    check_same([](SubdivisionRequest& request) {
      request.levels = 2;
      request.budget_bytes = kBudgetOfTwoLevels;
      request.normals = request.limit = true;
    });
  }
  SECTION("two threads, in double") {
    check_same([](SubdivisionRequest& request) {
      request.levels = 2;
      request.budget_bytes = kBudgetOfTwoLevels;
      request.threads = 2;
      request.normals = true;
      request.precision = ComponentType::kFloat64;
    });
  }
  SECTION("another scheme") {
    check_same([](SubdivisionRequest& request) {
      request.levels = 2;
      request.budget_bytes = kBudgetOfTwoLevels;
      request.scheme = scheme_from_name("midpoint");
    });
  }
  SECTION("without an index, and with few pieces") {
    check_same([&](SubdivisionRequest& request) {
      request.no_index = true;
      request.budget_bytes = BaseInRanges::whole_bytes(path) - 1;
    });
  }
}

TEST_CASE("What a subdivision in pieces cannot do is refused, and nothing is left") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  laid_out_at(path, mesh_for_pieces());
  SubdivisionRequest request = request_in_pieces(path, files.path() / "s.plait");
  const auto check_refused = [&](ErrorCode code, const char* says) {
    const Error error = error_of([&] { (void)run_request(request); });
    CHECK(error.code() == code);
    CHECK_THAT(error.what(), Catch::Matchers::Contains(says));
    CHECK(Directory(files.path()).names() == std::vector<std::string>{"m.base"});
  };
  SECTION("another executor") {
    request.executor = ExecutorKind::kSweep;
    check_refused(ErrorCode::kBudget, "executor sweep");
  }
  SECTION("a run that can be resumed") {
    request.resume = true;
    check_refused(ErrorCode::kBudget, "resumed");
  }
  SECTION("another layout") {
    request.layout = LayoutKind::kRcm;
    check_refused(ErrorCode::kBudget, "layout rcm");
  }
  SECTION("a scheme of two rings") {
    request.scheme = scheme_from_name("butterfly");
    check_refused(ErrorCode::kBudget, "butterfly");
  }
  SECTION("a refinement in memory") {
    request.levels = 2;
    request.max_slot_bytes = 12;
    check_refused(ErrorCode::kBudget, "--max-slot");
  }
  SECTION("a backend that compresses") {
    request.backend = "compressed";
    request.block_bytes.reset();
    check_refused(ErrorCode::kBudget, "backend compressed");
  }
  SECTION("no level") {
    request.levels = 0;
    check_refused(ErrorCode::kBudget, "level 0");
  }
  SECTION("cancelled") {
    std::uint64_t calls = 0;
    JobWatch watch;
    watch.progress = [&](const Progress& now) { return now.phase != "subdivision" || ++calls < 3; };
    CHECK(code_of([&] { (void)run_request(request, watch); }) == ErrorCode::kCancelled);
    CHECK(Directory(files.path()).names() == std::vector<std::string>{"m.base"});
  }
  SECTION("damage") {
    const std::uint64_t size = std::filesystem::file_size(path / kBaseIndexName);
    const std::uint64_t place = GENERATE(1u, 2u, 3u) * size / 4;
    std::fstream index(path / kBaseIndexName, std::ios::binary | std::ios::in | std::ios::out);
    index.seekp(static_cast<std::streamoff>(place));
    index.write("damage", 6);
    index.close();
    check_refused(ErrorCode::kCorruption, "checksum of the page");
  }
}

TEST_CASE("A vertex with more faces than a piece may have is refused") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  laid_out_at(path, bipyramid(6000));
  SubdivisionRequest request = request_in_pieces(path, files.path() / "s.plait");
  request.budget_bytes = 256 << 10;
  const Error error = error_of([&] { (void)run_request(request); });
  CHECK(error.code() == ErrorCode::kBudget);
  CHECK_THAT(error.what(), Catch::Matchers::Contains("faces around"));
  CHECK(Directory(files.path()).names() == std::vector<std::string>{"m.base"});
}

}  // namespace plait::test
