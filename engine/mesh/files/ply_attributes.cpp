#include "mesh/files/ply_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kMostComponents = 255;
constexpr std::size_t kMostFaceAttributes = 255;

/// Finds groups of properties, and takes each property once.
class PropertyGroups {
 public:
  explicit PropertyGroups(const PlyElement& element)
      : properties_(element.properties), taken_(properties_.size(), false) {
    for (std::size_t at = 0; at < properties_.size(); ++at)
      taken_[at] = properties_[at].is_list || properties_[at].name == "x" ||
                   properties_[at].name == "y" || properties_[at].name == "z";
  }

  bool taken(std::size_t at) const { return taken_[at]; }

  /// Takes the properties with these names if all are there and have one type.
  std::optional<PlyAttribute> take(const std::string& attribute,
                                   const std::vector<std::string>& names) {
    PlyAttribute result;
    for (const std::string& name : names) {
      const auto found = std::ranges::find(properties_, name, &PlyProperty::name);
      if (found == properties_.end()) return std::nullopt;
      const auto at = static_cast<std::size_t>(found - properties_.begin());
      const std::size_t first = result.properties.empty() ? at : result.properties[0];
      if (taken_[at] || found->type != properties_[first].type) return std::nullopt;
      result.properties.push_back(at);
    }
    for (const std::size_t at : result.properties) taken_[at] = true;
    result.schema = {attribute, properties_[result.properties[0]].type,
                     static_cast<std::uint32_t>(names.size())};
    return result;
  }

  /// NAME_0, NAME_1 and so on, or NAME_x, NAME_y and NAME_z, if `first` is the first of them.
  std::optional<PlyAttribute> take_numbered(const std::string& first) {
    if (first.size() < 3 || first[first.size() - 2] != '_') return std::nullopt;
    const std::string name = first.substr(0, first.size() - 2);
    if (first.back() == 'x') return take(name, {name + "_x", name + "_y", name + "_z"});
    if (first.back() != '0') return std::nullopt;
    std::vector<std::string> names;
    while (names.size() < kMostComponents) {
      std::string next = fmt::format("{}_{}", name, names.size());
      if (std::ranges::find(properties_, next, &PlyProperty::name) == properties_.end()) break;
      names.push_back(std::move(next));
    }
    return names.size() < 2 ? std::nullopt : take(name, names);
  }

 private:
  const std::vector<PlyProperty>& properties_;
  std::vector<bool> taken_;
};

bool is_attribute_name(std::string_view name) {
  return !name.empty() && name.size() <= 31 && name != "position" &&
         std::ranges::all_of(name, [](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-';
         });
}

}  // namespace

std::vector<PlyAttribute> attributes_of(const PlyElement& vertices,
                                        std::vector<std::string>& left_out) {
  PropertyGroups groups(vertices);
  std::vector<PlyAttribute> attributes;
  const auto add = [&](std::optional<PlyAttribute> found) {
    if (!found) return false;
    const std::string name = found->schema.name;
    const bool is_new = std::ranges::none_of(
        attributes, [&](const PlyAttribute& each) { return each.schema.name == name; });
    if (is_new && is_attribute_name(name))
      attributes.push_back(std::move(*found));
    else
      left_out.push_back(name);
    return true;
  };
  add(groups.take("normal", {"nx", "ny", "nz"}));
  if (!add(groups.take("color", {"red", "green", "blue", "alpha"})))
    add(groups.take("color", {"red", "green", "blue"}));
  if (!add(groups.take("texture", {"s", "t"}))) add(groups.take("texture", {"u", "v"}));
  // Groups first: a file may have NAME_1 before NAME_0.
  for (const PlyProperty& property : vertices.properties)
    if (!property.is_list) add(groups.take_numbered(property.name));
  for (std::size_t at = 0; at < vertices.properties.size(); ++at) {
    const PlyProperty& property = vertices.properties[at];
    // The second property of a name is not found by it.
    if (property.is_list ||
        (!groups.taken(at) && !add(groups.take(property.name, {property.name}))))
      left_out.push_back(property.name);
  }
  return attributes;
}

std::vector<PlyAttribute> face_attributes_of(const PlyElement& faces,
                                             std::vector<std::string>& left_out) {
  std::vector<PlyAttribute> attributes;
  for (std::size_t at = 0; at < faces.properties.size(); ++at) {
    const PlyProperty& property = faces.properties[at];
    const bool is_new = std::ranges::none_of(
        attributes, [&](const PlyAttribute& each) { return each.schema.name == property.name; });
    if (property.is_list || !is_new || !is_attribute_name(property.name) ||
        attributes.size() == kMostFaceAttributes) {
      left_out.push_back(property.name);
      continue;
    }
    PlyAttribute& attribute = attributes.emplace_back();
    attribute.schema = {property.name, property.type, 1};
    attribute.properties = {at};
  }
  return attributes;
}

PLAIT_END_NAMESPACE
