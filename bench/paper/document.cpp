#include "paper/document.h"

#include <fmt/format.h>

#include <cstddef>

#include "instrument/figure_text.h"

namespace plait::paper {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLineWidth = 110;

std::string table_text(const DocumentTable& table) {
  std::vector<std::vector<std::string>> rows = {table.columns};
  rows.insert(rows.end(), table.rows.begin(), table.rows.end());
  return instrument::aligned(rows, false);
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) {
    line += ' ';
    for (const char character : cell) {
      if (character == '|') line += '\\';
      line += character;
    }
    line += " |";
  }
  return line + "\n";
}

std::string table_markdown(const DocumentTable& table) {
  std::string text = markdown_row(table.columns) + "|---|";
  for (std::size_t column = 1; column < table.columns.size(); ++column) text += "---:|";
  text += "\n";
  for (const std::vector<std::string>& row : table.rows) text += markdown_row(row);
  return text;
}

}  // namespace

std::string to_text(const Document& document) {
  std::string text = document.title() + "\n";
  for (const Document::Part& part : document.parts()) switch (part.kind) {
      case Document::Kind::kHeading:
        text += fmt::format("\n{}\n{:-<{}}\n", part.text, "", part.text.size());
        break;
      case Document::Kind::kParagraph:
        text += instrument::wrapped(part.text, kLineWidth);
        break;
      case Document::Kind::kCommand:
        text += fmt::format("    {}\n", part.text);
        break;
      case Document::Kind::kTable:
        text += fmt::format("\n{}\n", table_text(part.table));
        break;
      case Document::Kind::kPicture:
        text += fmt::format("{}: {}\n", part.file.native(), part.text);
        break;
    }
  return text;
}

std::string to_markdown(const Document& document, const fs::path& directory) {
  std::string text = fmt::format("# {}\n", document.title());
  for (const Document::Part& part : document.parts()) switch (part.kind) {
      case Document::Kind::kHeading:
        text += fmt::format("## {}\n", part.text);
        break;
      case Document::Kind::kParagraph:
        text += instrument::wrapped(part.text, kLineWidth) + "\n";
        break;
      case Document::Kind::kCommand:
        text += fmt::format("    {}\n\n", part.text);
        break;
      case Document::Kind::kTable:
        text += table_markdown(part.table) + "\n";
        break;
      case Document::Kind::kPicture:
        text += fmt::format("![{}]({})\n\n", part.text,
                            fs::absolute(part.file)
                                .lexically_normal()
                                .lexically_relative(fs::absolute(directory).lexically_normal())
                                .generic_string());
        break;
    }
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace plait::paper
