#include "acceptance/random_calls/machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "plait/error.h"
#include "support/parallel_loops.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kBudgets[] = {64 << 10, kSmallBudget, 16 << 20};

const BaseMesh& mesh_number(std::uint32_t number) {
  static const std::array<BaseMesh, 3> meshes = {BaseMesh::build(sheet(6, 5)),
                                                 BaseMesh::build(random_torus(2, 20)),
                                                 BaseMesh::build(tetrahedron())};
  return meshes[number % meshes.size()];
}

}  // namespace

const std::vector<Machine::Kind>& Machine::kinds() {
  static const std::vector<Kind> all = [] {
    std::vector<Kind> found;
    for (const std::string& backend : usable_backends())
      if (backend == "compressed")
        for (const char* pipeline :
             {"shuffle,lz4", "zstd:1", "hierarchy,zstd:1", "predicted,zstd:1"})
          found.push_back({backend, pipeline});
      else
        found.push_back({backend, "none"});
    return found;
  }();
  return all;
}

Machine::Machine(const Script& script, Outcomes* outcomes)
    : base_(mesh_number(script.begin.mesh)),
      kind_(kinds()[script.begin.backend % kinds().size()]),
      budget_(kBudgets[script.begin.budget % std::size(kBudgets)]),
      outcomes_(outcomes) {
  if (script.begin.mesh / 3 % 2 == 1) pool_ = by_other_threads(2);
  if (script.begin.mesh / 6 % 3 == 1) io_threads_ = 0;
  coded_ = kind_.pipeline.starts_with("hierarchy") || kind_.pipeline.starts_with("predicted");
  create();
}

void Machine::run(const Call& call) {
  const std::string& name = current_ = call.name;
  const auto a = call.a, b = call.b, c = call.c;
  if (name == "open") return open(a);
  if (name == "guest") return guest();
  if (name == "leave") return leave(a);
  if (name == "release") return release(a);
  if (name == "view") return view(a, b, c);
  if (name == "gone") return gone();
  if (!store_) return;
  if (name == "add") add(a, b, c);
  if (name == "level") add_level(a);
  if (name == "remove") remove(a);
  if (name == "replace") replace(a, b);
  if (name == "sweep") sweep_over(a, b, c);
  if (name == "visit") visit(a, b, c);
  if (name == "writer") write_patches(a, b, c);
  if (name == "subdivide") refine(a, b, c);
  if (name == "commit") commit();
  if (name == "roll_back") roll_back();
  if (name == "close") close();
  if (name == "drop") drop();
  if (name == "reader") reader();
  if (name == "base") write_base(a, b);
  if (name == "face") face(a, b, c);
  if (name == "text") text(a, b);
  if (name == "walk") walk(a, b, c);
  if (name == "digest") compare_digest();
  if (name == "verify") check_blocks();
  if (name == "recode") recode(a, b);
  if (name == "busy") second_writer();
}

std::uint64_t Machine::readers() const {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(kept_, [](const Kept& kept) { return kept.of_main; }));
}

StoreEvents Machine::listener() {
  heard_ = all_heard_.emplace_back(std::make_shared<Heard>());
  return {[heard = heard_](const StoreEvent& event) {
    if (heard->is_over) heard->was_late = true;
    if (event.kind == StoreEvent::Kind::kOpened) ++heard->opened;
    if (event.kind != StoreEvent::Kind::kOpened && event.kind != StoreEvent::Kind::kCommitted)
      return;
    heard->committed += event.kind == StoreEvent::Kind::kCommitted ? 1 : 0;
    heard->last_version = event.version;
  }};
}

void Machine::check() {
  for (const std::shared_ptr<Heard>& heard : all_heard_)
    require(!heard->was_late, "an event of a store that is gone");
  if (store_) compare(*store_, now_, "the store");
  for (const Guest& guest : guests_) compare(guest.store, guest.content, "a guest");
  for (const Kept& kept : kept_)
    for (const Seen& seen : kept.views) check_view(seen);
}

void Machine::compare(const Store& store, const Content& content, const char* whose) {
  std::string wrong;
  try {
    wrong = difference(store, content);
  } catch (const Error& error) {
    wrong = error.what();
  }
  // The smallest budgets may have no room beside views.
  if (budget_ <= kSmallBudget && wrong.find("available") != std::string::npos) return;
  require(wrong.empty(), fmt::format("{}: {}", whose, wrong));
}

void Machine::count(bool done) {
  if (outcomes_ == nullptr) return;
  ++(done ? outcomes_->of(current_).done : outcomes_->of(current_).refused);
}

std::set<ErrorCode> Machine::with_budget(std::set<ErrorCode> codes) const {
  if (budget_ <= kSmallBudget) codes.insert(ErrorCode::kBudget);
  if (coded_) codes.insert(ErrorCode::kBadState);
  return codes;
}

}  // namespace plait::test
