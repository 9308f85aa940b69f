// Subdivisions, compared with the same ones of a store in memory.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "acceptance/random_calls/machine.h"
#include "plait/error.h"
#include "plait/registry.h"

namespace plait::test {
namespace {

/// What a subdivision makes, and others keep.
bool is_made(std::string_view name) { return name == "position" || name == "normal"; }

SubdivideOptions options_of(std::uint32_t a, std::uint32_t b) {
  SubdivideOptions what;
  what.levels = static_cast<int>(a % (kFinestOfScripts + 1));
  what.normals = b % 2 == 0;
  what.limit = b / 2 % 4 == 0;
  what.executor = static_cast<ExecutorKind>(b / 8 % 4);
  what.scheme =
      std::array<Scheme, 3>{Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint}[a / 4 % 3];
  what.threads = 1 + static_cast<int>(a / 16 % 2);
  return what;
}

}  // namespace

void Machine::check_others_kept(const Content& before, const Content& after) {
  for (const Content::Attribute& attribute : before.attributes) {
    if (is_made(attribute.schema.name) || !attribute.is_finished()) continue;
    const auto same = std::ranges::find(after.attributes, attribute.schema,
                                        [](const auto& each) { return each.schema; });
    require(same != after.attributes.end() && same->base == attribute.base &&
                std::ranges::equal(same->levels, attribute.levels, {}, &Content::Level::bytes,
                                   &Content::Level::bytes),
            fmt::format("subdivide has changed '{}'", attribute.schema.name));
  }
}

void Machine::check_made(Content& after, Content& expected) {
  for (const char* name : {"position", "normal"}) {
    const Content::Attribute *found = after.find(name), *right = expected.find(name);
    require((found == nullptr) == (right == nullptr),
            fmt::format("subdivide: attribute '{}'", name));
    if (found == nullptr) continue;
    require(found->base == right->base && found->levels.size() == right->levels.size(),
            fmt::format("subdivide: base records or levels of '{}'", name));
    for (std::size_t level = 0; level < right->levels.size(); ++level)
      require(found->levels[level].bytes == right->levels[level].bytes,
              fmt::format("subdivide: level {} of '{}'", level + 1, name));
  }
}

/// What the same call gives in a store in memory. Nothing if that is an error, whose code is added
/// to `also`, or not known.
std::optional<Content> Machine::expected_of(SubdivideOptions plain, bool commits_levels,
                                            std::set<ErrorCode>& also) {
  if (!now_.is_finished()) {
    also.insert({ErrorCode::kInvalidArgument, ErrorCode::kNotSupported});
    return std::nullopt;
  }
  Store reference = loaded(base_, now_);
  if (commits_levels && plain.executor == ExecutorKind::kAuto)
    plain.executor = ExecutorKind::kSweep;
  try {
    subdivide(reference, plain);
    return content_of(reference);
  } catch (const Error& error) {
    also.insert(error.code());
    return std::nullopt;
  }
}

void Machine::refine(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (now_.find("position") == nullptr) return;
  const SubdivideOptions what = options_of(a, b);
  const std::uint32_t how = c % 5;  // 4: commits each level
  bool committed = false;
  SubdivideOptions watched = what;
  if (how < 4) watched.progress = watcher(how, c / 5 % 6);
  if (how == 4)
    watched.level_done = [&](int) {
      // Other attributes may be unfinished; then nothing is committed.
      try {
        store_->commit();
        committed = true;
      } catch (const Error& error) {
        require(error.code() == ErrorCode::kBadState, error.what());
      }
    };

  std::set<ErrorCode> also = with_budget({ErrorCode::kBadState});
  std::optional<Content> expected = expected_of(what, how == 4, also);
  // The fused executor does not go on from levels.
  also.insert(ErrorCode::kNotSupported);
  // Normals that are there do not fit.
  if (now_.find("normal") != nullptr && !what.normals) also.insert(ErrorCode::kInvalidArgument);
  if (how == 1 || how == 2) also.insert(ErrorCode::kCancelled);
  Content before = now_;
  const bool done = change([&] { subdivide(*store_, watched); }, also);
  const std::string message = message_;
  now_ = content_of(*store_);
  check_others_kept(before, now_);
  if (done) {
    require(before.find("position")->is_finished(), "subdivide has refined unfinished positions");
    for (const Content::Attribute& attribute : now_.attributes)
      require(attribute.is_finished() || !is_made(attribute.schema.name),
              "subdivide has left a level unfinished: " + attribute.schema.name);
    if (expected) check_made(now_, *expected);
  } else if (!(now_ == before)) {  // otherwise it was refused before its first change
    require(message == "Thrown" || message.find("cancelled") != std::string::npos || committed,
            "a refused subdivide has changed the store (" + difference(*store_, before) +
                "): " + message);
    require(committed || !now_.is_finished(), "what subdivide has left can be committed");
  }
  if (committed) take_over_commit();
}

/// What exactly was committed is known only to the callback: the store says it.
void Machine::take_over_commit() {
  sequence_ = store_->sequence();
  require(sequence_ > 0, "a commit without a version");
  if (on_disk()) {
    Store seen = Store::open(path(), {}, default_backends());
    committed_ = content_of(seen);
  } else {
    unknown_commit_ = true;
  }
}

}  // namespace plait::test
