#include "derived_attributes.h"

#include <algorithm>
#include <utility>

#include "plait/derivation.h"

namespace plait {
namespace {

/// What stands before the pipeline in a text of --compress: [ATTRIBUTE][@LEVELS]; may be empty.
std::string_view place_in(std::string_view text) {
  const std::size_t equals = text.find('=');
  const bool names = equals != std::string_view::npos && equals < text.find_first_of(":,+");
  return names ? text.substr(0, equals) : std::string_view();
}

/// Takes "ATTRIBUTE=word" out of the texts, and returns the attributes.
std::set<std::string> take(std::vector<std::string>& texts, std::string_view word) {
  std::set<std::string> taken;
  std::erase_if(texts, [&](const std::string& text) {
    const std::string_view attribute = place_in(text);
    if (attribute.empty() || text.substr(attribute.size() + 1) != word) return false;
    taken.emplace(attribute);
    return true;
  });
  return taken;
}

}  // namespace

std::set<std::string> take_derived(std::vector<std::string>& texts) {
  return take(texts, kDerived);
}

std::set<std::string> take_stored(std::vector<std::string>& texts) { return take(texts, "stored"); }

bool is_compressed_by(const std::vector<std::string>& texts, std::string_view attribute) {
  return std::ranges::any_of(texts, [&](const std::string& text) {
    const std::string_view place = place_in(text);
    const std::string_view named = place.substr(0, place.find('@'));
    return named.empty() || named == attribute;
  });
}

std::function<std::string(const AttributeSchema&)> with_derived(
    const Store& source, const std::set<std::string>& derived, const std::set<std::string>& kept,
    const std::vector<std::string>& texts, const BackendRegistry& backends,
    std::function<std::string(const AttributeSchema&)> stored) {
  for (const std::string& name : derived)
    backends.derivations()->usual(source.attributes()[source.attribute(name)].schema);
  for (const std::string& name : kept)
    source.attribute(name);  // an error for a name that is not there
  return [=, &source, stored = std::move(stored)](const AttributeSchema& schema) {
    if (derived.contains(schema.name)) return std::string(kDerived);
    const std::string_view derivation = source.derivation(source.attribute(schema.name));
    if (!derivation.empty() && !kept.contains(schema.name) && !is_compressed_by(texts, schema.name))
      return derived_pipeline(derivation);
    return stored(schema);
  };
}

}  // namespace plait
