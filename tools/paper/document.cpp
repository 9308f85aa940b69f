#include "paper/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <sstream>

namespace plait::paper {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLineWidth = 110;

/// Breaks the text between words.
std::string wrapped(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::string lines, line;
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      lines += line + "\n";
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return lines + line + "\n";
}

/// Characters, not bytes, for text in UTF-8.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }));
}

std::string row_text(const std::vector<std::string>& cells,
                     const std::vector<std::size_t>& widths) {
  std::string line;
  for (std::size_t column = 0; column < cells.size(); ++column) {
    const std::size_t space = widths[column] - width_of(cells[column]);
    if (column > 0) line.append(2 + space, ' ');
    line += cells[column];
    if (column == 0) line.append(space, ' ');
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line + "\n";
}

std::string table_text(const DocumentTable& table) {
  std::vector<std::size_t> widths;
  for (std::size_t column = 0; column < table.columns.size(); ++column) {
    std::size_t width = width_of(table.columns[column]);
    for (const std::vector<std::string>& row : table.rows)
      width = std::max(width, width_of(row[column]));
    widths.push_back(width);
  }
  std::string text = row_text(table.columns, widths);
  for (const std::vector<std::string>& row : table.rows) text += row_text(row, widths);
  return text;
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
        text += fmt::format("\n{}\n{:-<{}}\n", part.text, "", width_of(part.text));
        break;
      case Document::Kind::kParagraph:
        text += wrapped(part.text, kLineWidth);
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
        text += wrapped(part.text, kLineWidth) + "\n";
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
