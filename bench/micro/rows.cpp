// What does a row of points cost on each instruction set of this processor? The program measures
// the row functions of the fused executor alone, with data in the first-level cache. So it shows a
// set for which the compiler made code without vectors. No set should take longer than a narrower
// one.
//
//   plait_bench_rows [--only TEXT] [--points 32] [--runs 15]
//
// It prints a line for every row and instruction set, the narrowest set first: nanoseconds per
// vertex (a vertex is a point of one lane), the ratio to the next narrower set, and the ratio to
// copying the result within the cache. Figures are medians of all turns; ratios are computed within
// a turn.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fused/patch_lattice.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "rows/dispatched_rows.h"
#include "rows/every_target.h"
#include "rows/record_normals.h"
#include "schemes/library_rule.h"
#include "schemes/loop.h"
#include "schemes/midpoint.h"

namespace {

using namespace plait;
using namespace plait::bench;

/// Adjacent rows of a patch, stored as during refinement.
template <class Real>
class Rows {
 public:
  explicit Rows(std::int64_t points)
      : width_(2 * points + 2), numbers_(kRows * width_), normals_(2 * width_) {
    // A curved surface: every normal has length one, and no two points are equal.
    for (std::int64_t row = 0; row < kRows; ++row)
      for (std::int64_t point = 0; point < width_; ++point)
        for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
          const Real i = static_cast<Real>(point), j = static_cast<Real>(row);
          lattice_points::put(at(row, point), lane,
                              {i, j, Real(0.01) * i * j + static_cast<Real>(lane)});
        }
  }

  Real* at(std::int64_t row, std::int64_t point) const {
    return numbers_.data() + (row * width_ + point) * std::int64_t{kPointNumbers};
  }
  float* normals() const { return normals_.data(); }
  /// The six neighbours of the points of row 1 from point 1 on.
  Neighbours<Real> neighbours() const {
    return {{{at(1, 2), at(1, 0)}, {at(2, 1), at(0, 1)}, {at(2, 0), at(0, 2)}}};
  }
  Real* result() const { return at(kRows - 2, 0); }

 private:
  static constexpr std::int64_t kRows = 7;
  std::int64_t width_;
  LatticeBuffer<Real> numbers_;
  LatticeBuffer<float> normals_;
};

/// make() returns a function that does the work on the instruction set that is active at that
/// moment.
struct Subject {
  std::string name;
  std::int64_t vertices;
  std::size_t vertex_bytes;
  std::function<std::function<void()>()> make;
};

template <class Real>
std::vector<Subject> subjects(std::int64_t points, const std::string& suffix) {
  const auto rows = std::make_shared<Rows<Real>>(points);
  const std::int64_t vertices = points * std::int64_t{kPatchLanes};
  const auto work = [](auto function, auto row) {
    return std::function<void()>([function, row] { function(row); });
  };
  std::vector<Subject> made;
  const RingShape shape{6, false, 1}, shape_of_two{6, false, 2};
  const auto rings = std::make_shared<Rows<Real>>(static_cast<std::int64_t>(shape_of_two.points()));
  const auto add = [&](const std::string& name, auto make) {
    made.push_back(
        {name + suffix, vertices, 3 * sizeof(Real), [make, rows, rings] { return make(); }});
  };
  const OddRow<Real> odd{rows->at(0, 0), rows->at(1, 0), rows->at(0, 1),
                         rows->at(1, 1), rows->result(), points};
  const EvenRow<Real> even{rows->at(3, 0), rows->neighbours(), rows->result(), points};
  const WingedRow<Real> winged{rows->at(1, 1), rows->at(1, 2), rows->at(2, 1), rows->at(0, 2),
                               rows->at(2, 0), rows->at(0, 3), rows->at(2, 2), rows->at(0, 1),
                               rows->result(), points};
  const SurfaceRow<Real, Real> limit{rows->at(1, 1), rows->neighbours(), rows->result(), 1, points};
  const RingStep<Real> step{rings->at(0, 0), rings->at(3, 0), 6, false};
  const auto add_rings = [&](const std::string& name, std::size_t ring_points, auto make) {
    add(name, make);
    made.back().vertices = static_cast<std::int64_t>(ring_points * kPatchLanes);
  };
  // The library's rows, and those that a program compiles which has the same rule as its own.
  const auto add_loop = [&](const std::string& name, auto rule) {
    add(name + " odd", [=] { return [=, at = rule()] { at.odd_row(odd); }; });
    add(name + " even", [=] { return [=, at = rule()] { at.even_row(even); }; });
    add(name + " limit", [=] { return [=, at = rule()] { at.limit_row(limit); }; });
    add_rings(name + " ring of 6", shape.points(),
              [=] { return [=, at = rule()] { at.ring_step(step); }; });
  };
  add_loop("Loop", [] { return library_rule<LoopRule, Real>(); });
  add_loop("own Loop", [] {
    return OneRing<Real>(std::make_shared<LoopRule>(), functions_of<Real, LoopRule>());
  });
  const auto midpoint = [] { return library_rule<MidpointRule, Real>(); };
  add("midpoint odd", [=] { return [=, at = midpoint()] { at.odd_row(odd); }; });
  add("midpoint even", [=] { return [=, at = midpoint()] { at.even_row(even); }; });
  add("Butterfly odd", [=] { return work(butterfly_rows<Real>().odd, winged); });
  add_rings("Butterfly rings of 6", shape_of_two.points(),
            [=] { return work(butterfly_rows<Real>().ring_step, step); });
  add("normals", [=] {
    return work(normal_row<Real>(), SurfaceRow<Real, float>{rows->at(1, 1), rows->neighbours(),
                                                            rows->normals(), 1, points});
  });
  made.back().vertex_bytes = 3 * sizeof(float);
  // Rows 0 to 2 of a curved surface, as records.
  const std::int64_t width = vertices + 2 + std::int64_t{kPatchLanes};
  const auto records = std::make_shared<std::vector<Vector3<Real>>>();
  for (int row = 0; row < 3; ++row)
    for (std::int64_t point = 0; point < width; ++point) {
      const Real i = static_cast<Real>(point), j = static_cast<Real>(row);
      records->push_back({i, j, Real(0.01) * i * j});
    }
  add("normals of records", [=] {
    const auto at = [&](std::int64_t row, std::int64_t point) {
      return records->data() + row * width + point;
    };
    return std::function<void()>(
        [records, function = record_normals_row<Real>(),
         run = RecordNormals<Real>{
             {{at(1, 2), at(1, 0)}, {at(2, 1), at(0, 1)}, {at(2, 0), at(0, 2)}},
             vertices,
             reinterpret_cast<Vector3<float>*>(rows->normals())}] { function(run); });
  });
  made.back().vertex_bytes = 3 * sizeof(float);
  return made;
}

double ns_a_vertex(const Subject& subject, const std::function<void()>& work) {
  const std::int64_t repetitions = std::max<std::int64_t>(1, 400'000 / subject.vertices);
  work();
  return 1e9 / static_cast<double>(repetitions * subject.vertices) * thread_seconds([&] {
           for (std::int64_t i = 0; i < repetitions; ++i) work();
         });
}

std::function<void()> copy_as_many(const Subject& subject) {
  const auto bytes = static_cast<std::size_t>(subject.vertices) * subject.vertex_bytes;
  return [from = std::vector<std::byte>(bytes), to = std::vector<std::byte>(bytes)]() mutable {
    std::memcpy(to.data(), from.data(), to.size());
    asm volatile("" ::"r"(to.data()) : "memory");  // keeps the compiler from removing the copy
  };
}

void run(const Settings& settings) {
  std::vector<Subject> all = subjects<float>(settings.points, ", float32");
  std::ranges::move(subjects<double>(settings.points, ", float64"), std::back_inserter(all));
  Measurements table("row|instruction set",
                     {{"ns a vertex", 2, true}, {"over the narrower set"}, {"over memcpy"}});
  for (const Subject& subject : all) {
    if (subject.name.find(settings.only) == std::string::npos) continue;
    for (int turn = 0; turn < settings.runs; ++turn) {
      const double copy = ns_a_vertex(subject, copy_as_many(subject));
      double narrower = Measurements::kNone;
      fused_rows::on_every_target([&](const char* target) {
        const double ns = ns_a_vertex(subject, subject.make());
        table.add({subject.name, target}, {ns, ns / narrower, ns / copy});
        narrower = ns;
      });
    }
  }
  table.print(fmt::format("rows of {} points in {} lanes, {} runs", settings.points, kPatchLanes,
                          settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_rows", "Rows of the fused executor on every instruction set",
                 {.runs = 15}, {"--points", "--runs", "--only"})
      .run(count, words, run);
}
