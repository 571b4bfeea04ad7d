// A program with the vendor's AdsLib for many_programs.py; `.ci/foreign-suites` builds it.
// It subscribes so many times to a counter, and prints what came behind each line of its standard
// input, and at its end.
// Arguments: NetId of the target, address of the router, number of the program, subscriptions.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>

#include "AdsLib.h"

static std::mutex guard;
static std::map<uint32_t, uint32_t> last;
static uint32_t number;
static unsigned long samples, missed, gaps, restarts, foreign, ends;

static void came(const AmsAddr *, const AdsNotificationHeader *header, uint32_t subscription)
{
    std::lock_guard<std::mutex> lock(guard);
    if (header->cbSampleSize < 4) {
        ++ends;
        return;
    }
    uint32_t value;
    std::memcpy(&value, header + 1, 4);
    const uint32_t count = value / 16;
    ++samples;
    foreign += value && value % 16 != number;
    const auto before = last.find(subscription);
    if (before != last.end()) {
        restarts += count < before->second;
        if (before->second && count > before->second + 1) {
            missed += count - before->second - 1;
            ++gaps;
        }
    }
    last[subscription] = count;
}

static void check(long code, const char *what)
{
    if (code) {
        std::fprintf(stderr, "%s: 0x%lx\n", what, code);
        std::exit(1);
    }
}

int main(int, char **words)
{
    uint8_t id[6];
    const char *text = words[1];
    for (auto &part : id)
        part = static_cast<uint8_t>(std::strtoul(text + (*text == '.'), const_cast<char **>(&text), 10));
    const AmsAddr target{{id[0], id[1], id[2], id[3], id[4], id[5]}, 851};
    number = std::strtoul(words[3], nullptr, 10);
    const uint32_t subscriptions = std::strtoul(words[4], nullptr, 10);
    check(bhf::ads::AddLocalRoute(target.netId, words[2]), "route");
    const long port = AdsPortOpenEx();
    const std::string name = "MAIN.aCount[" + std::to_string(number) + "]";
    for (uint32_t each = 0; each < subscriptions; ++each) {
        uint32_t handle = 0, length = 0, subscription = 0;
        check(AdsSyncReadWriteReqEx2(port, &target, 0xF003, 0, 4, &handle, name.size() + 1,
                                     name.c_str(), &length), "handle");
        AdsNotificationAttrib attributes{4, 4, 0, {0}};
        check(AdsSyncAddDeviceNotificationReqEx(port, &target, 0xF005, handle, &attributes, &came,
                                                each, &subscription), "subscription");
    }
    std::printf("ready\n");
    std::fflush(stdout);
    for (int character = 0; character != EOF;) {
        character = std::getchar();
        if (character != '\n' && character != EOF)
            continue;
        std::lock_guard<std::mutex> lock(guard);
        std::printf("{\"samples\": %lu, \"missed\": %lu, \"gaps\": %lu, \"restarts\": %lu, "
                    "\"foreign\": %lu, \"ends\": %lu, \"subscriptions\": %zu}\n",
                    samples, missed, gaps, restarts, foreign, ends, last.size());
        std::fflush(stdout);
    }
    std::_Exit(0);
}
