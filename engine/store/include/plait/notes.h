// plait/notes.h: what a store has beside its levels: attributes of base faces, and texts. Every
// commit records them, and copies and exports have them.
//
//   store.notes().set_text("unit", "mm");
//   store.notes().add_face_attribute({"material", ComponentType::kUint16, 1});
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/provenance.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Store::notes(). Threads: as the store. Calls that change something have the errors of other
/// changes of the store: kBadState for a store that was opened for reading and while a pass is
/// under way, kBusy while the store has readers or views.
class StoreNotes {
 public:
  /// Attributes of the faces of Store::base(): material, part number. They have names of their own,
  /// and one number for each face.
  std::span<const AttributeSchema> face_attributes() const;
  /// Adds one, of zeros. Errors: kInvalidArgument for a name that is taken or ill-formed, for
  /// more than one component, and for more than 255 face attributes.
  void add_face_attribute(AttributeSchema schema);
  /// Errors: kNotFound.
  void remove_face_attribute(std::string_view name);
  /// One number for each face of Store::base(), in memory. Without const, for writing. Errors:
  /// kNotFound; kInvalidArgument if the attribute has another type.
  template <class Number>
  std::span<Number> face_records(std::string_view name) {
    const std::span<std::byte> bytes = face_bytes(name, RecordTraits<Number>::kType);
    return {reinterpret_cast<Number*>(bytes.data()), bytes.size() / sizeof(Number)};
  }
  template <class Number>
  std::span<const Number> face_records(std::string_view name) const {
    const std::span<const std::byte> bytes = face_bytes(name, RecordTraits<Number>::kType);
    return {reinterpret_cast<const Number*>(bytes.data()), bytes.size() / sizeof(Number)};
  }
  /// The same for a program that learns the type only while it runs.
  std::span<std::byte> face_bytes(std::string_view name, std::optional<ComponentType> type = {});
  std::span<const std::byte> face_bytes(std::string_view name,
                                        std::optional<ComponentType> type = {}) const;

  /// What people note about the store (plait/extend/provenance.h).
  const Texts& texts() const;
  /// Sets a text; an empty one removes it. Errors: kInvalidArgument unless `name` has 1 to 255
  /// characters of [A-Za-z0-9_-] and `text` is UTF-8 of at most 64 KiB without control characters
  /// but tab and line feed.
  void set_text(std::string_view name, std::string_view text);

  StoreNotes(const StoreNotes&) = delete;
  StoreNotes& operator=(const StoreNotes&) = delete;

 private:
  friend struct Store::Implementation;
  explicit StoreNotes(Store::Implementation& store) : store_(store) {}
  ~StoreNotes() = default;

  Store::Implementation& store_;
};

PLAIT_END_NAMESPACE
