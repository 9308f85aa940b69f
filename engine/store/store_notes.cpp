// What a store has beside levels: attributes of the base faces, and texts.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "format/version_description.h"
#include "plait/error.h"
#include "plait/notes.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::size_t face_attribute_of(const Store::Implementation& state, std::string_view name,
                              std::optional<ComponentType> type) {
  std::string known;
  for (std::size_t at = 0; at < state.face_infos.size(); ++at) {
    const AttributeSchema& schema = state.face_infos[at];
    if (schema.name != name) {
      known += (known.empty() ? "" : ", ") + schema.name;
      continue;
    }
    if (type && schema.type != *type)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("read face attribute '{}': it has {} records, but the caller expects "
                              "{}",
                              name, to_string(schema.type), to_string(*type)));
    return at;
  }
  throw Error(ErrorCode::kNotFound,
              fmt::format("{}: no face attribute '{}'; there are: {}", state.name(), name,
                          known.empty() ? "none" : known));
}

}  // namespace

StoreNotes& Store::notes() { return state().notes; }
const StoreNotes& Store::notes() const { return state().notes; }

std::span<const AttributeSchema> StoreNotes::face_attributes() const { return store_.face_infos; }

void StoreNotes::add_face_attribute(AttributeSchema schema) try {
  Store::Implementation& state = store_;
  begin_change(state, Change::kAdd, "add a face attribute to");
  const auto refuse = [&](const std::string& what) {
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("add face attribute '{}': {}", schema.name, what));
  };
  if (!is_attribute_name(schema.name))
    throw refuse(fmt::format("expected a name of 1 to {} characters of [A-Za-z0-9_-]",
                             kMaxAttributeNameBytes));
  if (component_bytes(schema.type) == 0 || schema.components != 1)
    throw refuse(fmt::format("expected one number of a known type, found {} x {}",
                             to_string(schema.type), schema.components));
  if (std::ranges::find(state.face_infos, schema.name, &AttributeSchema::name) !=
      state.face_infos.end())
    throw refuse("the name is taken");
  if (state.face_infos.size() >= kMaxFaceAttributes)
    throw refuse(fmt::format("expected fewer than {} face attributes", kMaxFaceAttributes));
  if (state.next_number == std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("add face attribute '{}': the store has used all attribute numbers",
                            schema.name));
  Store::Implementation::FaceAttribute attribute;
  attribute.number = state.next_number;
  attribute.bytes.resize(state.base.face_count() * schema.record_bytes());
  state.face_infos.reserve(state.face_infos.size() + 1);
  state.face_attributes.push_back(std::move(attribute));
  state.face_infos.push_back(std::move(schema));
  ++state.next_number;
} catch (const std::bad_alloc&) {
  throw out_of_memory("add a face attribute to " + store_.name());
}

void StoreNotes::remove_face_attribute(std::string_view name) {
  Store::Implementation& state = store_;
  begin_change(state, Change::kRemove, "remove a face attribute of");
  const auto at = static_cast<std::ptrdiff_t>(face_attribute_of(state, name, {}));
  state.face_infos.erase(state.face_infos.begin() + at);
  state.face_attributes.erase(state.face_attributes.begin() + at);
}

std::span<std::byte> StoreNotes::face_bytes(std::string_view name,
                                            std::optional<ComponentType> type) {
  Store::Implementation& state = store_;
  const std::size_t at = face_attribute_of(state, name, type);
  begin_change(state, Change::kRecords,
               "change face records (a const Store gives them to read) of");
  state.face_attributes[at].changes.are_lent = true;
  return state.face_attributes[at].bytes;
}

std::span<const std::byte> StoreNotes::face_bytes(std::string_view name,
                                                  std::optional<ComponentType> type) const {
  const Store::Implementation& state = store_;
  return state.face_attributes[face_attribute_of(state, name, type)].bytes;
}

const Texts& StoreNotes::texts() const { return store_.texts; }

void StoreNotes::set_text(std::string_view name, std::string_view text) try {
  Store::Implementation& state = store_;
  begin_change(state, Change::kAdd, "set a text of");
  if (!is_attribute_name(name))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("set text '{}': expected a name of 1 to {} characters of "
                            "[A-Za-z0-9_-]",
                            name.substr(0, kMaxAttributeNameBytes), kMaxAttributeNameBytes));
  Texts former = state.texts;
  if (text.empty())
    state.texts.erase(std::string(name));
  else
    state.texts.insert_or_assign(std::string(name), std::string(text));
  try {
    encode_description(state.description());  // refuses text that a version cannot record
  } catch (...) {
    state.texts = std::move(former);
    throw;
  }
} catch (const std::bad_alloc&) {
  throw out_of_memory("set a text of " + store_.name());
}

PLAIT_END_NAMESPACE
