// Calls of passes, with callbacks that cancel, throw and call back.
#include <fmt/format.h>

#include <string>
#include <utility>

#include "acceptance/random_calls/machine.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"

namespace plait::test {

void Machine::call_back(std::uint32_t which) {
  Store& store = *store_;
  const auto refuses = [&](const std::string& what, const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      // What subdivide() is asked for is checked first.
      require(error.code() == ErrorCode::kBadState || error.code() == ErrorCode::kBusy ||
                  what == "subdivide",
              fmt::format("{} in a callback: {}", what, error.what()));
      return;
    }
    throw Wrong(fmt::format("{} works in a callback", what));
  };
  switch (which % 10) {
    case 0:
      return refuses("close", [&] { store.close(); });
    case 1:
      return refuses("roll_back", [&] { store.roll_back(); });
    case 2:
      return refuses("commit", [&] { store.commit(); });
    case 3:
      return refuses("remove_attribute", [&] { store.remove_attribute(0); });
    case 4:
      return refuses("add_attribute", [&] {
        store.add_attribute({"callback", ComponentType::kUint8, 1});
      });
    case 5:
      return refuses("base_bytes", [&] { store.base_bytes(0); });
    case 6:
      return refuses("subdivide", [&] { subdivide(store, {.levels = kFinestOfScripts}); });
    case 7:
      return refuses("set_text", [&] { store.set_text("t", "x"); });
    case 8:
      std::as_const(store).base_bytes(0);
      store.attributes();
      store.statistics();
      return;
    default:
      // Levels of which the pass makes none can be read.
      try {
        const Reader reader(store);
        reader.read_patch(0, 0);
      } catch (const Error& error) {
        require(error.code() == ErrorCode::kBudget || error.code() == ErrorCode::kBadState,
                error.what());
      }
  }
}

ProgressCallback Machine::watcher(std::uint32_t how, std::uint32_t after) {
  return [this, how, left = after](const Progress&) mutable {
    if (left > 0) {
      --left;
      return true;
    }
    if (how == 1) return false;
    if (how == 2) throw Thrown();
    if (how == 3) call_back(pokes_++);
    return true;
  };
}

void Machine::sweep_over(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto id = any_attribute(a);
  if (!id || now_.attributes[*id].levels.empty()) return;
  Content::Attribute& attribute = now_.attributes[*id];
  const int level = 1 + static_cast<int>(b % attribute.levels.size());
  Content::Level& of = attribute.levels[static_cast<std::size_t>(level - 1)];
  const bool overwrites = c % 2 == 0;
  const std::uint32_t how = c / 2 % 4;
  const std::size_t record_bytes = attribute.schema.record_bytes();
  const LevelGeometry geometry = base_.geometry(relative_to_base(level, 0), record_bytes, 4096);
  SweepPass pass{
      "random",
      {{*id, level, level, overwrites ? Access::kOverwrite : Access::kUpdate, Reach::kOwn}},
      [&](const SweepView& view, EdgeId edge, int) {
        const std::span<std::byte> bytes = view.slot(0, level, edge).bytes;
        if (overwrites)
          fill_pattern(attribute.schema, b, geometry.slot(edge).offset, bytes);
        else
          change_pattern(attribute.schema, bytes);
      }};
  SweepOptions options;
  options.threads = 1 + static_cast<int>(c / 8 % 2);
  options.progress = watcher(how, c / 16 % 2);
  std::set<ErrorCode> also = with_budget({});
  if (!overwrites && !of.finished) also.insert(ErrorCode::kBadState);
  if (how == 1) also.insert(ErrorCode::kCancelled);
  if (how == 2) also.insert(ErrorCode::kCancelled);
  const bool done = change([&] { sweep(*store_, pass, options); }, also);
  if (done || message_ == "Thrown" || message_.find("cancelled") != std::string::npos)
    touched(attribute.schema.name);
  if (done) {
    require(overwrites || of.finished, "an update of an unfinished level succeeded");
    if (overwrites)
      fill_pattern(attribute.schema, b, 0, of.bytes);
    else
      change_pattern(attribute.schema, of.bytes);
    of.finished = true;
  } else if (!StoreAccess::level_file(std::as_const(*store_), *id, level).is_finished()) {
    of.finished = false;
  }
  if (done && how == 2) require(c / 16 % 2 > 0, "what a callback throws does not come out");
}

}  // namespace plait::test
