// Calls that read: readers, views, walks, digests, and verification.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "acceptance/random_calls/machine.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/patch.h"
#include "plait/extend/recode_attribute.h"
#include "plait/verify.h"

namespace plait::test {

void Machine::check_reader(const Reader& reader) {
  if (!now_.attributes.empty() && now_.is_finished())
    code_of_call([&] { reader.read_patch(0, 0); });
}

void Machine::reader() {
  if (kept_.size() >= 3) return;
  Kept kept;
  kept.reader.emplace(*store_);
  kept.content = &now_;
  kept.of_main = true;
  kept_.push_back(std::move(kept));
}

void Machine::view(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (kept_.empty()) return;
  Kept& kept = kept_[a % kept_.size()];
  if (!kept.reader || !kept.content || kept.views.size() >= 3) return;
  const Content& content = *kept.content;
  if (content.attributes.empty()) return;
  const auto face = static_cast<FaceId>(b % base_.face_count());
  int finest = kFinestOfScripts + 1;
  for (const auto& attribute : content.attributes) finest = std::min(finest, attribute.finest());
  const int level = static_cast<int>(c % static_cast<std::uint32_t>(finest + 1));
  bool finished = true;
  for (const auto& attribute : content.attributes) finished = finished && attribute.base_finished;
  for (const auto& attribute : content.attributes)
    for (int at = 0; at < level; ++at)
      finished = finished && attribute.levels[static_cast<std::size_t>(at)].finished;
  if (c % 5 == 0) {
    kept.reader->prefetch(std::array{face, FaceId{0}}, level);
    if (c % 2 == 0) kept.reader->end_prefetch();
  }
  std::optional<PatchView> patch;
  const auto code = code_of_call([&] { patch = kept.reader->read_patch(face, level); });
  if (code) {
    require((!finished && *code == ErrorCode::kBadState) || with_budget({}).contains(*code),
            "read a patch: " + message_);
    return;
  }
  require(finished, "a view shows an unfinished level");
  Seen seen{std::move(*patch), {}};
  for (const auto& attribute : content.attributes)
    seen.patches.emplace_back(attribute.schema.name, patch_of(base_, attribute, face, level));
  check_view(seen);
  kept.views.push_back(std::move(seen));
}

void Machine::release(std::uint32_t a) {
  if (kept_.empty()) return;
  const auto at = kept_.begin() + static_cast<std::ptrdiff_t>(a % kept_.size());
  if (a % 2 == 0 && !at->views.empty()) {
    at->reader.reset();  // the views stay
    at->views.pop_back();
    if (!at->views.empty()) return;
  }
  kept_.erase(at);
}

void Machine::walk(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto id = any_attribute(a);
  if (!id) return;
  const Content::Attribute& attribute = now_.attributes[*id];
  if (attribute.schema.type != ComponentType::kFloat32 || attribute.schema.components != 3) return;
  const int level = static_cast<int>(c / 8) % (attribute.finest() + 1);
  const auto face = static_cast<FaceId>(b % base_.face_count());
  bool finished = attribute.base_finished;
  for (int at = 0; at < level; ++at)
    finished = finished && attribute.levels[static_cast<std::size_t>(at)].finished;
  std::optional<StorePatches<Vector3<float>>> patches;
  std::vector<const Vector3<float>*> records;  // of the patch, in row order
  const std::int64_t size = std::int64_t{1} << level;
  const auto code = code_of_call([&] {
    patches.emplace(*store_, *id, budget_ / 2, Reach::kOwn);
    patches->activate(level, 1, 0);
    auto patch = patches->patch(face);
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i) records.push_back(&patch.at(level, i, j));
  });
  if (code) {
    require((!finished && *code == ErrorCode::kBadState) || with_budget({}).contains(*code),
            "walk over patches: " + message_);
    return;
  }
  require(finished, "a walk shows an unfinished level");
  const Bytes expected = patch_of(base_, attribute, face, level);
  const auto check_pinned = [&] {
    Bytes found;
    for (const Vector3<float>* const record : records) {
      const auto bytes = std::as_bytes(std::span(record, 1));
      found.insert(found.end(), bytes.begin(), bytes.end());
    }
    require(found == expected, "a walk shows other records");
  };
  check_pinned();
  call_beside_pins(*id, c);
  check_pinned();
}

void Machine::call_beside_pins(AttributeId pinned, std::uint32_t which) {
  const auto refuses = [&](const char* what, const auto& call) {
    const auto code = code_of_call(call);
    require(code == ErrorCode::kBadState || code == ErrorCode::kBusy,
            fmt::format("{} beside a walk: {}", what, code ? message_ : "works"));
  };
  switch (which % 8) {
    case 0:
      return refuses("remove_attribute", [&] { store_->remove_attribute(pinned); });
    case 1:
      return refuses("roll_back", [&] { store_->roll_back(); });
    case 2:
      return refuses("close", [&] { store_->close(); });
    case 3:
      if (kind_.backend != "compressed") return;
      return refuses("recode", [&] { recode_attribute(*store_, pinned, LevelPipelines("fast")); });
    case 4:
      return compare_digest();
    case 5:
      return text(which / 8, which);
    case 6:
      return add(which / 8, 0, 2);
    default:
      if (!coded_) commit();  // else levels are encoded first, which replaces what is pinned
  }
}

void Machine::check_view(const Seen& seen) {
  for (const auto& [name, expected] : seen.patches) {
    Bytes found(expected.size());
    seen.view.records(name).copy_to(found);
    require(found == expected, fmt::format("a view of '{}' shows other records", name));
  }
}

void Machine::compare_digest() {
  const bool finished = now_.is_finished();
  std::optional<Digest> found;
  const auto code = code_of_call([&] { found = digest(std::as_const(*store_), {.threads = 2}); });
  if (code) {
    require((!finished && *code == ErrorCode::kBadState) || with_budget({}).contains(*code),
            "digest: " + message_);
    return;
  }
  require(finished, "a digest of an unfinished level");
  require(*found == digest(loaded(base_, now_)), "another digest");
}

void Machine::check_blocks() {
  const auto code = code_of_call([&] {
    require(verify(std::as_const(*store_)).damaged_count == 0, "verify finds damaged blocks");
  });
  require(!code || with_budget({}).contains(*code), "verify: " + message_);
}

}  // namespace plait::test
