// Calls that change what a store holds, without a pass.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "acceptance/random_calls/machine.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/recode_attribute.h"
#include "plait/notes.h"

namespace plait::test {
namespace {

const std::vector<AttributeSchema>& schemas() {
  static const std::vector<AttributeSchema> all = {{"", ComponentType::kUint8, 5},
                                                   {"", ComponentType::kFloat32, 3},
                                                   {"", ComponentType::kUint16, 1}};
  return all;
}

}  // namespace

void Machine::add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  AttributeSchema schema = schemas()[b % schemas().size()];
  schema.name = fmt::format("n{}", a % 4);
  const int finest = static_cast<int>(c % 3);
  const bool taken = now_.find(schema.name) != nullptr;
  std::set<ErrorCode> also;
  if (taken) also.insert(ErrorCode::kInvalidArgument);
  // The filter takes floats only.
  if (kind_.pipeline.starts_with("hierarchy") && schema.type != ComponentType::kFloat32)
    also.insert(ErrorCode::kNotSupported);
  if (!change([&] { store_->add_attribute(schema, finest); }, also)) return;
  require(!taken, "two attributes of one name");
  Content::Attribute attribute;
  attribute.schema = schema;
  attribute.base.resize(base_.vertex_count() * schema.record_bytes());
  now_.attributes.push_back(std::move(attribute));
  for (int level = 1; level <= finest; ++level) append_level(now_.attributes.back());
}

void Machine::append_level(Content::Attribute& attribute) const {
  const auto bytes = base_
                         .geometry(relative_to_base(attribute.finest() + 1, 0),
                                   attribute.schema.record_bytes(), 4096)
                         .total_bytes();
  attribute.levels.push_back({Bytes(bytes), true});
}

std::optional<AttributeId> Machine::any_attribute(std::uint32_t a) const {
  if (now_.attributes.empty()) return std::nullopt;
  return static_cast<AttributeId>(a % now_.attributes.size());
}

void Machine::add_level(std::uint32_t a) {
  const auto id = any_attribute(a);
  if (!id || now_.attributes[*id].finest() >= kFinestOfScripts) return;
  if (!change([&] { store_->add_level(*id); })) return;
  append_level(now_.attributes[*id]);
}

void Machine::remove(std::uint32_t a) {
  const auto id = any_attribute(a);
  if (!id || (a % 8 != 0 && now_.attributes[*id].schema.name == "position")) return;
  if (!change([&] { store_->remove_attribute(*id); }, with_budget({}))) return;
  now_.attributes.erase(now_.attributes.begin() + *id);
}

void Machine::replace(std::uint32_t a, std::uint32_t b) {
  const auto old = any_attribute(a), by = any_attribute(b);
  if (!old || !by) return;
  const bool same_type = now_.attributes[*old].schema.type == now_.attributes[*by].schema.type;
  std::set<ErrorCode> also = with_budget({});
  const bool of_scheme =
      now_.attributes[*old].schema.name == "position" && !store_->provenance().scheme.empty();
  if (*old == *by || (of_scheme && !same_type)) also.insert(ErrorCode::kInvalidArgument);
  if (!change([&] { store_->replace_attribute(*old, *by); }, also)) return;
  require(*old != *by && !(of_scheme && !same_type), "a wrong replacement");
  std::string name = now_.attributes[*old].schema.name;
  now_.attributes[*old] = now_.attributes[*by];
  now_.attributes[*old].schema.name = std::move(name);
  now_.attributes.erase(now_.attributes.begin() + *by);
}

void Machine::write_base(std::uint32_t a, std::uint32_t b) {
  const auto id = any_attribute(a);
  if (!id) return;
  Content::Attribute& attribute = now_.attributes[*id];
  Bytes bytes(attribute.base.size());
  fill_pattern(attribute.schema, b, 0, bytes);
  std::set<ErrorCode> also = with_budget({});
  if (!attribute.base_finished) also.insert(ErrorCode::kBadState);
  if (!change([&] { std::ranges::copy(bytes, store_->base_bytes(*id).begin()); }, also)) return;
  require(attribute.base_finished, "unfinished base records were given out");
  attribute.base = std::move(bytes);
}

void Machine::face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::string name = fmt::format("f{}", a % 2);
  const auto found = std::ranges::find_if(
      now_.face_attributes, [&](const auto& each) { return each.schema.name == name; });
  if (found == now_.face_attributes.end()) {
    const AttributeSchema schema{name, b % 2 == 0 ? ComponentType::kUint8 : ComponentType::kUint32,
                                 1};
    if (!change([&] { store_->notes().add_face_attribute(schema); })) return;
    now_.face_attributes.push_back({schema, Bytes(base_.face_count() * schema.record_bytes())});
  } else if (c % 3 == 0) {
    if (!change([&] { store_->notes().remove_face_attribute(name); })) return;
    now_.face_attributes.erase(found);
  } else {
    Bytes numbers(found->numbers.size());
    fill_pattern(found->schema, b, 0, numbers);
    if (!change([&] { std::ranges::copy(numbers, store_->notes().face_bytes(name).begin()); }))
      return;
    found->numbers = std::move(numbers);
  }
}

void Machine::text(std::uint32_t a, std::uint32_t b) {
  const std::string name = fmt::format("t{}", a % 3), text(b % 5, 'x');
  if (!change([&] { store_->notes().set_text(name, text); })) return;
  now_.texts.erase(name);
  if (!text.empty()) now_.texts[name] = text;
}

void Machine::recode(std::uint32_t a, std::uint32_t b) {
  const auto id = any_attribute(a);
  if (!id || kind_.backend != "compressed") return;
  static constexpr std::array kPipelines = {"lz4", "shuffle,zstd:1", "hierarchy,lz4"};
  std::set<ErrorCode> also = with_budget({});
  also.insert(ErrorCode::kBadState);
  const AttributeSchema& schema = now_.attributes[*id].schema;
  if (schema.type != ComponentType::kFloat32)
    also.insert({ErrorCode::kInvalidArgument, ErrorCode::kNotSupported});
  const char* const pipeline = kPipelines[b % kPipelines.size()];
  if (!change([&] { recode_attribute(*store_, *id, LevelPipelines(pipeline)); }, also)) return;
  coded_ = coded_ || pipeline[0] == 'h';
  require(now_.attributes[*id].is_finished(), "recode read an unfinished level");
}

void Machine::commit() {
  const bool finished = now_.is_finished();
  const std::uint64_t told = heard_->committed;
  if (!change([&] { store_->commit(); },
              finished ? std::set<ErrorCode>{} : std::set{ErrorCode::kBadState}))
    return;
  require(finished, "an unfinished level or unfinished base records were committed");
  // What a callback has committed may be all there is.
  const bool differs = !unknown_commit_ && (sequence_ == 0 || !(now_ == committed_));
  const std::uint64_t found = store_->sequence();
  require(found == sequence_ + 1 || (found == sequence_ && !differs),
          fmt::format("version {} after version {}", found, sequence_));
  require(heard_->committed == told + (found - sequence_) && heard_->last_version == found,
          "the event of a commit");
  sequence_ = found;
  committed_ = now_;
  unknown_commit_ = false;
}

void Machine::roll_back() {
  if (!change([&] { store_->roll_back(); })) return;
  if (unknown_commit_) {
    now_ = content_of(*store_);
    require(now_.is_finished(), "rolled back to an unfinished level");
    committed_ = now_;
    unknown_commit_ = false;
    return;
  }
  const Provenance provenance = store_->provenance();
  now_ = sequence_ > 0 ? committed_ : Content();
  now_.provenance = provenance;
}

}  // namespace plait::test
