#include "server/volume/formats/detail/xml_document.hpp"

#include <expat.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxDepth = 64;

struct TreeBuilder {
  XML_Parser parser = nullptr;
  std::vector<XmlElement> open = {};  // From the outermost to the current element.
  XmlElement root = {};
  std::size_t elements = 0;
  std::string failure = {};

  void stop(std::string problem) {
    if (failure.empty()) failure = std::move(problem);
    XML_StopParser(parser, XML_FALSE);
  }

  static void XMLCALL on_start(void* self, const XML_Char* tag, const XML_Char** attributes) {
    auto& tree = *static_cast<TreeBuilder*>(self);
    if (++tree.elements > kMaxXmlElements || tree.open.size() >= kMaxDepth) {
      return tree.stop("its XML has too many elements");
    }
    std::string_view name = tag;
    name.remove_prefix(std::min(name.find(':') + 1, name.size()));
    XmlElement& element = tree.open.emplace_back(XmlElement{.name = std::string(name)});
    for (const XML_Char** at = attributes; *at != nullptr; at += 2) {
      element.attributes.emplace(at[0], at[1]);
    }
  }
  static void XMLCALL on_text(void* self, const XML_Char* text, int length) {
    auto& tree = *static_cast<TreeBuilder*>(self);
    if (!tree.open.empty()) tree.open.back().text.append(text, static_cast<std::size_t>(length));
  }
  static void XMLCALL on_end(void* self, const XML_Char*) {
    auto& tree = *static_cast<TreeBuilder*>(self);
    if (tree.open.empty()) return;
    XmlElement element = std::move(tree.open.back());
    tree.open.pop_back();
    element.text = trimmed(element.text);
    if (tree.open.empty()) {
      tree.root = std::move(element);
    } else {
      tree.open.back().children.push_back(std::move(element));
    }
  }
  static void XMLCALL on_entity(void* self, const XML_Char*, int, const XML_Char*, int,
                                const XML_Char*, const XML_Char*, const XML_Char*,
                                const XML_Char*) {
    static_cast<TreeBuilder*>(self)->stop("its XML declares entities, which are not allowed");
  }
};

void add_all(const XmlElement& element, std::string_view name,
             std::vector<const XmlElement*>& found) {
  for (const XmlElement& child : element.children) {
    if (child.name == name) found.push_back(&child);
    add_all(child, name, found);
  }
}

}  // namespace

std::string XmlElement::attribute(std::string_view key) const {
  const auto found = attributes.find(key);
  return found == attributes.end() ? std::string() : found->second;
}

const XmlElement* XmlElement::child(std::string_view tag) const {
  const auto found = std::find_if(children.begin(), children.end(),
                                  [&](const XmlElement& one) { return one.name == tag; });
  return found == children.end() ? nullptr : &*found;
}

std::string XmlElement::text_of(std::string_view tag) const {
  const XmlElement* const found = child(tag);
  return found == nullptr ? std::string() : found->text;
}

std::vector<const XmlElement*> XmlElement::all(std::string_view tag) const {
  std::vector<const XmlElement*> found;
  add_all(*this, tag, found);
  return found;
}

Result<XmlElement> parse_xml(std::string_view text) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  TreeBuilder tree{.parser = parser.get()};
  XML_SetUserData(parser.get(), &tree);
  XML_SetElementHandler(parser.get(), &TreeBuilder::on_start, &TreeBuilder::on_end);
  XML_SetCharacterDataHandler(parser.get(), &TreeBuilder::on_text);
  XML_SetEntityDeclHandler(parser.get(), &TreeBuilder::on_entity);
  if (text.size() > std::numeric_limits<int>::max()) {
    return fail(ErrorCode::kInvalidArgument, "its XML has more than 2 GiB");
  }
  const auto status = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
  if (!tree.failure.empty()) return fail(ErrorCode::kInvalidArgument, tree.failure);
  if (status != XML_STATUS_OK) {
    return fail(ErrorCode::kDamagedData,
                "its XML is damaged in line " +
                    std::to_string(XML_GetCurrentLineNumber(parser.get())) + " (" +
                    XML_ErrorString(XML_GetErrorCode(parser.get())) + ")");
  }
  return std::move(tree.root);
}

}  // namespace multitetra
