// bench/paper/document.h: a chapter as a list of parts, which is written as text for a terminal or
// as Markdown. It knows nothing of the paper: report.h makes the figures, and chapter.h puts them
// into words.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plait::paper {

/// Cells are text; a row has as many as there are columns. The first column is aligned to the left,
/// the others to the right.
struct DocumentTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// Headings, paragraphs, commands, tables and pictures in their order.
class Document {
 public:
  enum class Kind { kHeading, kParagraph, kCommand, kTable, kPicture };
  struct Part {
    Kind kind;
    std::string text;  ///< of a picture: its caption
    DocumentTable table = {};
    std::filesystem::path file = {};  ///< of a picture
  };

  explicit Document(std::string title) : title_(std::move(title)) {}
  void heading(std::string text) { parts_.push_back({Kind::kHeading, std::move(text)}); }
  void paragraph(std::string text) { parts_.push_back({Kind::kParagraph, std::move(text)}); }
  void command(std::string text) { parts_.push_back({Kind::kCommand, std::move(text)}); }
  void table(DocumentTable table) { parts_.push_back({Kind::kTable, {}, std::move(table)}); }
  void picture(std::filesystem::path file, std::string caption) {
    parts_.push_back({Kind::kPicture, std::move(caption), {}, std::move(file)});
  }
  const std::string& title() const { return title_; }
  const std::vector<Part>& parts() const { return parts_; }

 private:
  std::string title_;
  std::vector<Part> parts_;
};

/// Aligned columns. Pictures are named.
std::string to_text(const Document& document);
/// Lines of at most 110 characters where words allow it. Pictures are linked relative to
/// `directory`, where the page will be. A vertical bar in a cell is escaped.
std::string to_markdown(const Document& document, const std::filesystem::path& directory);

}  // namespace plait::paper
