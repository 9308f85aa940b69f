// ply_records.h: the properties of one element of a PLY file that become records of attributes.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "mesh/files/lost_digits.h"
#include "mesh/files/ply_attributes.h"
#include "mesh/files/ply_values.h"
#include "mesh/files/readers.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Takes elements one after another: value by value with read() and append(), or with their bytes.
class PlyRecords {
 public:
  /// Of no attributes.
  PlyRecords() = default;
  /// `element` outlives this object.
  PlyRecords(const PlyElement& element, std::vector<PlyAttribute> attributes);

  bool is_empty() const { return attributes_.empty(); }
  void reserve(std::uint64_t count);

  /// Reads the number of a property that is no list. REQUIRES: not is_empty().
  template <class Values>
  void read(Values& values, std::size_t property) {
    const ComponentType type = element_->properties[property].type;
    numbers_[property] = values.value(type);
    if constexpr (std::is_same_v<Values, TextPlyValues>)
      if (type == ComponentType::kFloat32)
        lost_digits_[property].add(values.word(), numbers_[property]);
  }
  /// Appends what read() has read. Errors: kInvalidArgument for a number that its type cannot hold.
  template <class Values>
  void append(const Values& values) {
    for (std::size_t at = 0; at < attributes_.size(); ++at)
      for (const std::size_t property : attributes_[at].properties)
        if (!append_number(at, property))
          values.refuse(fmt::format("a number of the type of {}",
                                    in_quotes(element_->properties[property].name)),
                        fmt::format("{}", numbers_[property]));
  }
  /// Appends the numbers of a binary element, whose lists have three entries each.
  void append_bytes(const char* element, bool big_endian) {
    for (const Part& part : parts_) {
      std::vector<std::byte>& to = records_[part.attribute];
      const std::byte* const from = reinterpret_cast<const std::byte*>(element) + part.offset;
      to.insert(to.end(), from, from + part.bytes);
      if (big_endian) std::reverse(to.end() - static_cast<std::ptrdiff_t>(part.bytes), to.end());
    }
  }

  /// Warns of the digits that texts of the numbers had and their types cannot hold.
  void say_lost_digits(const Input& input, Reading& reading) const;
  std::vector<MeshAttribute> finish();

 private:
  /// A number in the bytes of an element.
  struct Part {
    std::size_t offset, bytes, attribute;
  };
  bool append_number(std::size_t attribute, std::size_t property);

  const PlyElement* element_ = nullptr;
  std::vector<PlyAttribute> attributes_;
  std::vector<Part> parts_;                      ///< in the order of the attributes
  std::vector<std::vector<std::byte>> records_;  ///< [attribute]
  std::vector<double> numbers_;                  ///< [property] of the present element
  std::vector<LostDigits> lost_digits_;          ///< [property]
};

PLAIT_END_NAMESPACE
