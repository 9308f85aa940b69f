// Calls of passes, with callbacks that cancel, throw and call back.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "acceptance/random_calls/machine.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/notes.h"
#include "plait/patch_writer.h"
#include "plait/store_info.h"
#include "plait/visit_vertices.h"

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
      return refuses("set_text", [&] { store.notes().set_text("t", "x"); });
    case 8:
      store.attributes();
      store.info().paging;
      try {
        static_cast<void>(std::as_const(store).base_bytes(0));
      } catch (const Error& error) {  // of the pass, or left unfinished before
        require(error.code() == ErrorCode::kBadState, error.what());
      }
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

void Machine::visit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  using Record = Vector3<float>;
  const auto id = any_attribute(a);
  if (!id) return;
  Content::Attribute& attribute = now_.attributes[*id];
  const AttributeSchema schema = attribute.schema;
  if (schema.type != ComponentType::kFloat32 || schema.components != 3) return;
  const std::uint32_t how = c % 4;  // 1: throws at a level, 2: at the base vertices
  const bool overwrites = c / 4 % 2 == 0;
  bool throws = false;
  const auto kernel = [&](const VertexRun& run, std::span<Record> records) {
    const auto bytes = std::as_writable_bytes(records);
    if (overwrites)
      fill_pattern(schema, b, run.first * sizeof(Record), bytes);
    else
      change_pattern(schema, bytes);
    if (how == 1 || (how == 2 && run.level == 0)) {
      throws = true;
      throw Thrown();
    }
  };
  std::set<ErrorCode> also = with_budget({});
  if (!overwrites && !attribute.is_finished()) also.insert(ErrorCode::kBadState);
  if (how == 1 || how == 2) also.insert(ErrorCode::kCancelled);
  const VisitOptions options{.level = attribute.finest()};
  const bool done = change(
      [&] {
        if (overwrites)
          visit_vertices(*store_, options, std::tuple{plait::overwrites<Record>(schema.name)},
                         kernel);
        else
          visit_vertices(*store_, options, std::tuple{updates<Record>(schema.name)}, kernel);
      },
      also);
  require(done || throws || how == 0 || how == 3 || message_ != "Thrown", "a visit throws");
  if (!done && !throws) {
    // Within the budget, a visit is refused before its first change or not at all.
    const Content after = content_of(*store_);
    if (!(after == now_))
      require(!with_budget({}).empty(), "a refused visit has changed the store");
    now_ = after;
    return;
  }
  require(overwrites || attribute.is_finished(), "an update of unfinished records began");
  attribute.base_finished = done;
  for (Content::Level& level : attribute.levels) level.finished = done;
  if (!done) return;
  const auto model = [&](Bytes& bytes) {
    overwrites ? fill_pattern(schema, b, 0, bytes) : change_pattern(schema, bytes);
  };
  model(attribute.base);
  for (Content::Level& level : attribute.levels) model(level.bytes);
}

void Machine::write_patches(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto id = any_attribute(a);
  if (!id) return;
  Content::Attribute& attribute = now_.attributes[*id];
  const int last = static_cast<int>(c % static_cast<std::uint32_t>(attribute.finest() + 1)),
            first = static_cast<int>(c / 4 % static_cast<std::uint32_t>(last + 1));
  const std::uint32_t how = c / 16 % 4;  // 1: some patches, 2: none, 3: finish() twice
  Content::Attribute made = attribute;
  if (first == 0) fill_pattern(made.schema, b, 0, made.base);
  for (int level = std::max(first, 1); level <= last; ++level)
    fill_pattern(made.schema, b, 0, made.levels[static_cast<std::size_t>(level - 1)].bytes);
  bool began = false;
  const auto write = [&] {
    PatchWriter writer(
        *store_, {.attributes = {made.schema.name}, .first_level = first, .last_level = last});
    began = true;
    const std::uint64_t faces = base_.face_count();
    const std::uint64_t written = how == 1 ? b % faces : how == 2 ? 0 : faces;
    for (FaceId face = 0; face < written; ++face)
      writer.write_patch_of_bytes(made.schema.name, face, last, patch_of(base_, made, face, last));
    if (how == 1 || how == 2) throw Thrown();
    writer.finish();
    if (how != 3) return;
    try {
      writer.finish();
    } catch (const Error& error) {
      require(error.code() == ErrorCode::kBadState, error.what());
      return;
    }
    throw Wrong("a patch writer was finished twice");
  };
  std::set<ErrorCode> also = with_budget({});
  if (coded_) also.insert(ErrorCode::kNotSupported);
  if (how == 1 || how == 2) also.insert(ErrorCode::kCancelled);
  const bool done = change(write, also);
  if (!began) return;
  if (done) attribute = made;
  if (first == 0) attribute.base_finished = done;
  for (int level = std::max(first, 1); level <= last; ++level)
    attribute.levels[static_cast<std::size_t>(level - 1)].finished = done;
  now_.provenance = store_->provenance();  // of written positions it names no scheme
}

}  // namespace plait::test
