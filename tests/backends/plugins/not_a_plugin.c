/* A shared library that has not the function of a plug-in. */
int plait_plugin_v0(void);
int plait_plugin_v0(void) { return 0; }
