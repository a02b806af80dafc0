// Reads the members of one JSON object of a scene; keeps the first error, which names file, field, value and what would
// be right.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include <nlohmann/json.hpp>

#include <alpenglow/core/result.hpp>

namespace alpenglow::sandbox {

using Json = nlohmann::json;

// As an error shows it: short, on one line.
[[nodiscard]] std::string shown(double number);
[[nodiscard]] std::string shown(const Json& value);

// What a key leaves out keeps its value.
class Reader {
public:
    Reader(const Json& object, std::string file, std::string prefix)
        : object_(object), file_(std::move(file)), prefix_(std::move(prefix)) {}

    void number(const char* key, double low, double high, double& out);
    void number(const char* key, double low, double high, float& out);
    void number(const char* key, double low, double high, int& out); // a whole number
    void numbers(const char* key, double low, double high, glm::vec3& out);
    void text(const char* key, std::string& out);
    void boolean(const char* key, bool& out);
    // One of several names; `out`: its index.
    void name(const char* key, std::span<const std::string_view> names, int& out);

    // The object under `key`; null if there is none.
    const Json* object(const char* key);
    // Every object of the array under `key`, in order; stops at the first error.
    void each(const char* key, const std::function<void(Reader& item)>& read);
    void require(const char* key);
    // Call last: any member that nobody asked for is an error.
    void no_others();
    void fail(const std::string& key, const std::string& value, const std::string& expected);

    [[nodiscard]] bool failed() const { return failed_; }
    [[nodiscard]] const Error& error() const { return error_; }
    [[nodiscard]] std::string where(const std::string& key) const { return file_ + ": " + prefix_ + key; }
    // Of the scene: what a section names is relative to its folder.
    [[nodiscard]] const std::string& file() const { return file_; }

private:
    const Json* find(const char* key);
    // Its number within the range; null if there is none.
    const Json* find_number(const char* key, double low, double high);

    const Json& object_;
    std::string file_;
    std::string prefix_;
    std::vector<std::string> known_;
    bool failed_ = false;
    Error error_;
};

} // namespace alpenglow::sandbox
