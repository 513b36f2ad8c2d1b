/* Loads two plugins, whose symbols all see each other, and prints which release each got. usage: two_releases FILE SO SO */
#include <dlfcn.h>
#include <stdio.h>

int main(int count, char** arguments) {
  for (int i = 2; i < count; ++i) {
    void* plugin = dlopen(arguments[i], RTLD_NOW | RTLD_GLOBAL);
    const char* (*call)(const char*) = NULL;
    if (plugin != NULL) *(void**)&call = dlsym(plugin, "version_by_host");
    if (call == NULL) return fprintf(stderr, "%s\n", dlerror()), 1;
    printf("%s\n", call(arguments[1]));
  }
  return 0;
}
