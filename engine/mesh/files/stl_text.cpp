#include "mesh/files/stl_text.h"

#include <fmt/format.h>

#include <cctype>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

void StlText::refuse(std::string_view expected) const {
  const std::string element = fmt::format("facet {}", facets_);
  if (found_.empty()) text_.refuse_end(element, expected);
  text_.refuse(element, expected, found_);
}

void StlText::next() {
  found_.clear();
  if (text_.seek_word()) found_ = text_.word();
  word_ = found_;
  for (char& c : word_) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

bool StlText::take_end(std::string_view of) {
  constexpr std::string_view kEnd = "end";
  if (word_ == kEnd)
    next();
  else if (word_.starts_with(kEnd))
    word_.erase(0, kEnd.size());
  else
    return false;
  if (word_ != of) refuse(fmt::format("end{}", of));
  return true;
}

bool StlText::pass_name() {
  const std::uint64_t line = text_.line();
  next();
  while (!word_.empty() && text_.line() == line) {
    if (word_ == "facet") {  // a name may have the word too
      next();
      if (word_ == "outer") return true;
      if (word_ != "normal") continue;
      next();
      if (parse_number(word_)) return true;
    } else if (word_ == "vertex") {  // a name may have the word and a number: three are none
      int numbers = 0;
      for (next(); numbers < 3 && parse_number(word_); next()) ++numbers;
      if (numbers == 3) refuse("facet before a vertex");
    } else {
      next();
    }
  }
  return false;
}

void StlText::pass_normal() {
  constexpr int kMostWords = 4;
  for (int words = 0; word_ != "outer" && word_ != "vertex"; ++words) {
    const bool is_other = word_.empty() || word_.starts_with("end") || word_ == "facet" ||
                          word_ == "solid" || word_ == "loop";
    if (is_other || words == kMostWords) refuse("outer loop");
    next();
  }
  if (word_ == "vertex") return;
  next();
  if (word_ != "loop") refuse("outer loop");
  next();
}

void StlText::read_vertex(Vector3<double>& corner) {
  if (word_ != "vertex") refuse("three vertices");
  for (int axis = 0; axis < 3; ++axis) {
    next();
    const std::optional<double> number = parse_number(word_);
    if (!number || !text_.input().takes(*number)) refuse("a finite number");
    corner[axis] = *number;
  }
  next();
}

bool StlText::next_facet(std::array<Vector3<double>, 3>& corners) {
  if (!has_begun_) {
    next();
    has_begun_ = true;
    if (word_ != "solid") refuse("solid");
  }
  bool in_facet = false;
  while (!in_facet) {
    if (word_.empty()) return false;
    if (word_ == "facet") {
      next();
      in_facet = true;
    } else if (word_ == "solid") {
      ++solids_;
      has_end_ = false;
      in_facet = pass_name();
    } else if (take_end("solid")) {
      has_end_ = true;
      in_facet = pass_name();
    } else {
      refuse("facet or endsolid");
    }
  }
  // Behind `endsolid`, the next solid began on the line of the name.
  if (std::exchange(has_end_, false)) ++solids_;
  pass_normal();
  for (Vector3<double>& corner : corners) read_vertex(corner);
  if (!take_end("loop")) refuse("endloop after three vertices");
  next();
  if (!take_end("facet")) refuse("endfacet");
  next();
  ++facets_;
  return true;
}

PLAIT_END_NAMESPACE
